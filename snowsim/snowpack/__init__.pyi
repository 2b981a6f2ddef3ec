"""What type checkers read in place of names that are loaded on first use."""

from snowsim.snowpack.matching import agreement as agreement
from snowsim.snowpack.matching import agreement_summary as agreement_summary
from snowsim.snowpack.matching import agreement_table as agreement_table
from snowsim.snowpack.physical import PRESETS as PRESETS
from snowsim.snowpack.physical import Climate as Climate
from snowsim.snowpack.physical import Radar as Radar
from snowsim.snowpack.physical import Snowpack as Snowpack
from snowsim.snowpack.physical import physical_parameters as physical_parameters
from snowsim.snowpack.profile import Reflectors as Reflectors
from snowsim.snowpack.profile import combine as combine
from snowsim.snowpack.simulation import simulate as simulate
from snowsim.snowpack.snow import accumulation as accumulation
from snowsim.snowpack.tables import by_year as by_year
from snowsim.snowpack.tables import pieces as pieces
from snowsim.snowpack.tables import table as table

"""What type checkers read in place of names that are loaded on first use."""

from snowsim.front import scenes as scenes
from snowsim.scoring import score_folders as score_folders
from snowsim.snowpack import Climate as Climate
from snowsim.snowpack import Radar as Radar
from snowsim.snowpack import Snowpack as Snowpack
from snowsim.snowpack import accumulation as accumulation
from snowsim.snowpack import agreement as agreement
from snowsim.snowpack import simulate as simulate
from snowsim.tracking import Tracker as Tracker
from snowsim.tracking import list_pretrained as list_pretrained

__version__: str

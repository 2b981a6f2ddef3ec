"""What type checkers read in place of names that are loaded on first use."""

from snowsim.tracking.files import track_files as track_files
from snowsim.tracking.trackers import Tracker as Tracker
from snowsim.tracking.trackers import list_pretrained as list_pretrained

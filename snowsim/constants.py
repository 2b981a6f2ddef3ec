"""Physical constants in SI units, and fixed numbers of the radar and of files."""

import math

SPEED_OF_LIGHT_M_S = 299_792_458.0  # SI definition of the metre
ICE_DENSITY_KG_M3 = 917.0  # Cuffey & Paterson (2010), The Physics of Glaciers, 4th ed.
WATER_DENSITY_KG_M3 = 1000.0  # convention for metres of water equivalent
GAS_CONSTANT_J_MOL_K = 8.31446261815324  # CODATA 2018, exact
KILOMETRE = 1000.0  # m
NEPERS = math.log(10) / 10  # natural logarithm of the power ratio of one decibel
EARTH_RADIUS_M = 6.371e6  # mean radius; distances are computed on a sphere
# The refractive index of dry snow is 1 + KOVACS_M3_KG * density: Kovacs, Gow & Morey (1995), Cold
# Reg. Sci. Technol. 23, 245-256.
KOVACS_M3_KG = 0.845e-3

# Processed part of the sweep, 2.30016 to 7.449984 GHz: 2012_Greenland_P3 parameter sheet of CReSIS.
PROCESSED_BANDWIDTH_HZ = 5.149824e9

BLOCK_LINES = 256  # range lines of a block of an echogram, and of its scene
OUTPUTS = ("side_1", "side_2", "side_3", "side_4", "side_5", "fuse")  # maps of the tracker
STATISTICS_CONTENT = "snowsim flight statistics 4"  # attribute `content` of the dataset
THIS_AGE = ("1980-01-06", "2100-01-01")  # times in files must lie between these days

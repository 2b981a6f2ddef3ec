# What the embedded flight's settings must hold before a job starts.

from snowsim.reference import checked_settings
from snowsim.reference.line import line_length_km


def check_reference(config):
    """Refuse settings of the reference flight that contradict each other, in one line, before any job starts."""
    try:
        checked_settings(config["reference"])
    except ValueError as error:
        raise WorkflowError(
            f"config: reference.{str(error).removeprefix('reference.')}"
        ) from None
    radar, flight = config["reference"]["radar"], config["flight"]
    length_km = (
        flight["n_frames"] * flight["n_range_lines"] * radar["line_spacing_m"] / 1e3
    )
    if length_km > line_length_km():
        raise WorkflowError(
            f"config: flight.n_frames: expected frames that fit on the line of {line_length_km():.0f} km, "
            f"got {flight['n_frames']} of {flight['n_range_lines']} lines, {length_km:.0f} km"
        )


check_reference(config)

"""What can go wrong in a way the user can mend: one class, and the few children worth telling apart."""


class VdoorError(ValueError):
    """Wrong use or input: the message names the place, what was wanted, what was found, the path last."""


class MapError(VdoorError):
    """A map file that cannot be read, or a map that has nothing to divide."""


class MapWarning(UserWarning):
    """A map that can be read but likely says what was not meant, or leaves something to be assumed."""


class SettingError(VdoorError):
    """A setting that does not exist or cannot have that value."""


class RecordingError(VdoorError):
    """A recording that is damaged, foreign or of another schema."""

"""The device stays light: it links no library that only a station or a desktop needs."""
import re

import programs

FORBIDDEN = re.compile(r"sqlite|OpenNI|freenect|SDL|imgui|gtk|Qt|opencv_(highgui|imgcodecs|viz)|assimp-gui", re.I)


def needed(program):
    result = programs.run("readelf", "-d", program)
    return re.findall(r"NEEDED.*\[(.*)\]", result.stdout)


libraries = needed(programs.DEVICE)
programs.check(len(libraries) > 3, "readelf names the device's libraries: " + " ".join(libraries))
programs.check(not [name for name in libraries if FORBIDDEN.search(name)], "none of them is a station's or a window toolkit's")
programs.check(any("sqlite" in name for name in needed(programs.STATION)), "the same look does find SQLite in the station")
programs.end()

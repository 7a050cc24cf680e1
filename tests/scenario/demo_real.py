import pathlib

import demo_check
import programs

if not pathlib.Path("/usr/share/visp-images-data/ViSP-images/mbt-depth/castel").is_dir():
    programs.skip("visp-images-data is not installed")
folder, out, report = demo_check.run_demo("--real")
demo_check.check_loop(out, report)
programs.check(report["track"]["station_lost_frames"] == 0, "the station tracks all frames by features alone")
programs.check(report["track"]["lost_frames"] == 0, "the device loses no frame with the adjusted model")
programs.end()

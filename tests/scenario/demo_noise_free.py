import demo_check
import programs

folder, out, report = demo_check.run_demo("--noise", "0")
demo_check.check_loop(out, report)
for label, iou in report["detect"]["iou"].items():
    programs.check(iou >= 0.97, f"IoU of {label} is {iou:.4f}: at least 0.97")
demo_check.check_tracking(report)
programs.end()

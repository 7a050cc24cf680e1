import demo_check
import programs

folder, out, report = demo_check.run_demo()
demo_check.check_loop(out, report)
detect = report["detect"]
programs.check(detect["recall"] >= 0.95, f"recall is {detect['recall']:.4f}: at least 0.95")
programs.check(detect["false_change"] < 0.005, f"false change is {detect['false_change']:.5f}: below 0.005")
demo_check.check_tracking(report)
demo_check.check_misplaced_markers(out)
programs.end()

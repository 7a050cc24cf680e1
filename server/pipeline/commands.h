#pragma once
// The subcommands of meshloop-station. Each adds itself to the parser and, when it is chosen, sets the action.
#include "common/program/program.h"

namespace meshloop {

void add_run_command(CLI::App& app, Action& action);
void add_detect_command(CLI::App& app, Action& action);
void add_adjust_command(CLI::App& app, Action& action);
void add_calibrate_command(CLI::App& app, Action& action);
void add_track_command(CLI::App& app, Action& action);
void add_scene_command(CLI::App& app, Action& action);
void add_simulate_command(CLI::App& app, Action& action);
void add_doctor_command(CLI::App& app, Action& action);

}  // namespace meshloop

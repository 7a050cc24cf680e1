#include "server/pipeline/commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Compares reality with a shared 3D model, adapts the model, and publishes every change.",
               "meshloop-station"};
  meshloop::Action action;
  meshloop::prepare(app);
  meshloop::add_run_command(app, action);
  meshloop::add_detect_command(app, action);
  meshloop::add_adjust_command(app, action);
  meshloop::add_track_command(app, action);
  meshloop::add_calibrate_command(app, action);
  meshloop::add_scene_command(app, action);
  meshloop::add_simulate_command(app, action);
  meshloop::add_doctor_command(app, action);
  return meshloop::run_program(app, argc, argv, action);
}

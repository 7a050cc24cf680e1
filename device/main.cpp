#include "device/pipeline/commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Tracks a colour camera against the shared 3D model and draws the augmented view.", "meshloop-device"};
  meshloop::Action action;
  meshloop::prepare(app);
  meshloop::add_run_command(app, action);
  meshloop::add_track_command(app, action);
  meshloop::add_doctor_command(app, action);
  return meshloop::run_program(app, argc, argv, action);
}

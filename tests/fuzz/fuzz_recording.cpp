// Rooms: common/recording common/image
// Files that people write or that come from elsewhere. The first byte chooses the reader, the rest is the file.
#include <stdlib.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

#include "common/base/file.h"
#include "common/image/image_file.h"
#include "common/recording/marker_file.h"
#include "common/recording/recording.h"

namespace {

std::filesystem::path make_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "meshloop-fuzz-XXXXXX").string();
  if (!::mkdtemp(name.data())) std::abort();
  return name;
}

// A rig that is right, so that the lists are read.
void read_as_lists(const std::filesystem::path& folder) {
  meshloop::Rig rig;
  rig.color = {64, 48, 50, 50, 32, 24, {}};
  rig.depth = rig.color;
  if (!meshloop::write_rig(folder / "rig.yaml", rig)) std::abort();
  std::filesystem::remove(folder / "groundtruth.txt");
  const auto recording = meshloop::Recording::open(folder);
  if (recording) (void)recording->read_frame(0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const std::filesystem::path folder = make_folder();
  const auto bytes = std::as_bytes(std::span{data + 1, size - 1});
  const auto as_file = [&](const char* name) {
    if (!meshloop::write_file(folder / name, bytes)) std::abort();
    return folder / name;
  };
  switch (data[0] % 8) {
    case 0:
      (void)meshloop::read_rig(as_file("rig.yaml"));
      break;
    case 1:
      (void)meshloop::read_trajectory(as_file("groundtruth.txt"));
      break;
    case 2:
      (void)meshloop::read_markers(as_file("markers.yaml"));
      break;
    case 3:
      (void)meshloop::read_color_image(as_file("color"));
      break;
    case 4:
      (void)meshloop::read_depth_units(as_file("depth"));
      break;
    case 5:
      (void)meshloop::read_tiff(as_file("difference.tiff"));
      break;
    case 6:
      (void)meshloop::parse_pose(std::string{reinterpret_cast<const char*>(data) + 1, size - 1});
      break;
    default:
      as_file("rgb.txt");
      as_file("depth.txt");
      read_as_lists(folder);
  }
  return 0;
}

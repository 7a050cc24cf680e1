// Writes a simulated recording anew, as another rig would have taken it: rewrite_recording FROM TO KIND.
//   brown     both lenses bent, five coefficients
//   rational  both lenses bent, eight coefficients
//   tum       the same images, depth in units of 0.2 mm
// Lenses are bent by OpenCV: its undistortPoints says where in the ideal picture each pixel of the bent one lies.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "common/recording/recording.h"

namespace {

using namespace meshloop;

class Bender {
 public:
  explicit Bender(const Camera& camera) {
    const cv::Matx33d K{camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
    const cv::Mat lens{1, static_cast<int>(camera.distortion.size()), CV_64F,
                       const_cast<double*>(camera.distortion.data())};
    cv::Mat bent(camera.height, camera.width, CV_32FC2);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) bent.at<cv::Vec2f>(y, x) = {static_cast<float>(x), static_cast<float>(y)};
    }
    cv::Mat ideal;
    cv::undistortPoints(bent.reshape(2, camera.width * camera.height), ideal, K, lens, cv::noArray(), K,
                        cv::TermCriteria{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-7});
    ideal_ = ideal.reshape(2, camera.height).clone();
  }

  [[nodiscard]] ColorImage bend(ColorImage image) const { return bend(std::move(image), CV_8UC3, cv::INTER_CUBIC); }
  [[nodiscard]] DepthImage bend(DepthImage image) const { return bend(std::move(image), CV_32F, cv::INTER_NEAREST); }

 private:
  template <class T>
  [[nodiscard]] Image<T> bend(Image<T> image, int type, int interpolation) const {
    Image<T> bent{image.width(), image.height()};
    const cv::Mat from{image.height(), image.width(), type, image.data()};
    cv::Mat to{bent.height(), bent.width(), type, bent.data()};
    cv::remap(from, to, ideal_, cv::noArray(), interpolation, cv::BORDER_CONSTANT);
    return bent;
  }

  cv::Mat ideal_;
};

bool change_rig(Rig& rig, std::string_view kind) {
  if (kind == "tum") {
    rig.depth_scale = 0.0002;
  } else if (kind == "brown") {
    rig.color.distortion = {-0.25, 0.08, 0.001, -0.0015, -0.01, 0, 0, 0};
    rig.depth.distortion = {-0.12, 0.03, -0.0008, 0.001, 0.01, 0, 0, 0};
  } else if (kind == "rational") {
    rig.color.distortion = {0.6, 0.3, 0.0005, -0.0004, 0.05, 0.9, 0.4, 0.1};
    rig.depth.distortion = {0.3, 0.1, -0.0005, 0.0008, 0.02, 0.45, 0.2, 0.03};
  } else {
    return false;
  }
  return true;
}

Status rewrite(const std::filesystem::path& from, const std::filesystem::path& to, std::string_view kind) {
  const auto recording = Recording::open(from);
  if (!recording) return fail(recording.error());
  Rig rig = recording->rig();
  if (!change_rig(rig, kind)) return fail("unknown kind");
  auto writer = RecordingWriter::create(to, rig);
  if (!writer) return fail(writer.error());
  const Bender color{rig.color};
  const Bender depth{rig.depth};
  const auto count = static_cast<int>(recording->depth_images().size());
  for (int i = 0; i < count; ++i) {
    auto frame = recording->read_frame(i);
    if (!frame) return fail(frame.error());
    if (auto ok = writer->add_color(frame->color_timestamp_s, color.bend(std::move(frame->color))); !ok) return ok;
    if (auto ok = writer->add_depth(frame->depth_timestamp_s, depth.bend(std::move(frame->depth))); !ok) return ok;
  }
  std::filesystem::copy(from / "groundtruth.txt", to / "groundtruth.txt");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto done = rewrite(argv[1], argv[2], argv[3]);
  if (!done) fmt::print(stderr, "{}\n", done.error().message);
  return done ? 0 : 1;
}

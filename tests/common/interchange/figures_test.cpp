// The figures of common/interchange/README.md:
//   test-common-interchange --gtest_also_run_disabled_tests --gtest_filter='*Figures*'
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <iostream>

#include "common/interchange/model_file.h"
#include "files.h"

namespace meshloop {
namespace {

constexpr int kCells = 1118;  // 2,499,848 triangles

class Figures : public test::Folder {};

/// In a process of its own, so that this one's memory shows nothing of it.
void in_child(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
}

double processor_s(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_mb(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void write_binary_stl(const Submesh& mesh, const std::filesystem::path& file) {
  std::vector<char> bytes(84 + 50 * mesh.triangles.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + 80, &count, 4);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::memcpy(bytes.data() + 84 + 50 * t + 12 + 12 * k, mesh.positions[mesh.triangles[t][k]].data(), 12);
    }
  }
  std::ofstream{file, std::ios::binary}.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void print_figures(const std::filesystem::path& file) {
  in_child([&file] {
    const auto start = std::chrono::steady_clock::now();
    const auto model = import_as_model(file);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (!model) {
      std::cout << model.error().message << '\n';
      ::_exit(1);
    }
    std::cout << fmt::format(
                     "{:<10} {:.1f} s; reader {:.1f} s of processor time, {:.0f} MB; program {:.1f} s, {:.0f} MB\n",
                     file.filename().string(), took.count(), processor_s(RUSAGE_CHILDREN), peak_mb(RUSAGE_CHILDREN),
                     processor_s(RUSAGE_SELF), peak_mb(RUSAGE_SELF))
              << std::flush;
  });
}

TEST_F(Figures, DISABLED_LoadingTwoAndAHalfMillionTriangles) {
  in_child([this] {
    Model model;
    model.nodes.push_back(make_node(1, "wall", test::grid(kCells, 1.0f / 512)));
    const bool written = export_model(model, path("large.ply")) && export_model(model, path("large.glb")) &&
                         export_model(model, path("large.obj"));
    write_binary_stl(*model.nodes[0].submesh, path("large.stl"));
    if (!written) ::_exit(1);
  });
  for (const char* name : {"large.ply", "large.stl", "large.glb", "large.obj"}) print_figures(path(name));
}

}  // namespace
}  // namespace meshloop

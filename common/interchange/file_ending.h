#pragma once
#include <algorithm>
#include <filesystem>
#include <string>

namespace meshloop {

/// ".glb" for "A.GLB".
[[nodiscard]] inline std::string lower_case_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

}  // namespace meshloop

#include "server/store/file_identity.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

namespace meshloop {

Result<FileIdentity> FileIdentity::of(const std::filesystem::path& file) {
  struct stat about {};
  if (::stat(file.c_str(), &about) != 0) {
    return fail(fmt::format("cannot read '{}': {}", file.string(), std::generic_category().message(errno)));
  }
  return FileIdentity{file, about};
}

Status FileIdentity::check() const {
  struct stat about {};
  if (::stat(file_.c_str(), &about) != 0) {
    return fail(fmt::format("'{}' was deleted or moved while it was in use; put it back, or import the model anew",
                            file_.string()));
  }
  if (about.st_dev != about_.st_dev || about.st_ino != about_.st_ino) {
    return fail(fmt::format("'{}' was replaced by another file while it was in use; open it again", file_.string()));
  }
  return {};
}

Status FileIdentity::check_content() const {
  if (auto same = check(); !same) return same;
  struct stat about {};
  const bool is_same = ::stat(file_.c_str(), &about) == 0 && about.st_size == about_.st_size &&
                       about.st_mtim.tv_sec == about_.st_mtim.tv_sec && about.st_mtim.tv_nsec == about_.st_mtim.tv_nsec;
  if (is_same) return {};
  return fail(fmt::format("'{}' was written by another program while it was read; try again", file_.string()));
}

}  // namespace meshloop

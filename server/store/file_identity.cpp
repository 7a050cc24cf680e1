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
  return FileIdentity{file, about.st_dev, about.st_ino};
}

Status FileIdentity::check() const {
  struct stat about {};
  if (::stat(file_.c_str(), &about) != 0) {
    return fail(fmt::format("'{}' was deleted or moved while it was in use; put it back, or import the model anew",
                            file_.string()));
  }
  if (about.st_dev != device_ || about.st_ino != number_) {
    return fail(fmt::format("'{}' was replaced by another file while it was in use; open it again", file_.string()));
  }
  return {};
}

}  // namespace meshloop

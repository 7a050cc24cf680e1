#pragma once
// What an importing child process hands to its parent: a result, in memory that both see, and its progress.
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/interchange/read_file.h"

namespace meshloop {

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_{fd} {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  void close();
  void take(int fd) {
    close();
    fd_ = fd;
  }

 private:
  int fd_;
};

/// A file without a name, written by the child.
class ChildResult {
 public:
  [[nodiscard]] Status open();

  /// In the child. False when there is no memory left for it.
  [[nodiscard]] bool write(const Result<ReadParts>& read) const;
  [[nodiscard]] bool write_error(const std::string& message) const;

  /// In the parent, after the child's end. Empty when the child left nothing.
  [[nodiscard]] std::optional<Result<ReadParts>> read() const;

 private:
  Descriptor memory_;
};

/// Percents as bytes through a pipe, which closes when the child ends.
class ChildProgress {
 public:
  [[nodiscard]] Status open();

  /// In the child.
  [[nodiscard]] Progress reporter();

  /// In the parent: hands on what the child reports until it has ended.
  void follow(const std::function<void(double)>& progress);

 private:
  Descriptor from_child_;
  Descriptor to_parent_;
};

}  // namespace meshloop

#pragma once
#include <dds/dds.h>

#include <string>
#include <utility>

#include "common/base/result.h"

namespace meshloop {

/// A DDS entity that is deleted with its owner. Move-only.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_{handle} {}
  Entity(Entity&& other) noexcept : handle_{std::exchange(other.handle_, 0)} {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }

  [[nodiscard]] dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

/// What a dds_create_... function returned: an entity, or an error that names what was to be created.
[[nodiscard]] inline Result<Entity> own(dds_entity_t created, const char* what) {
  if (created > 0) return Entity{created};
  return fail(std::string{"DDS refused to create "} + what + ": " + dds_strretcode(created));
}

}  // namespace meshloop

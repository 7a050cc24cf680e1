#pragma once
#include <dds/dds.h>

#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

inline constexpr unsigned kHighestDomain = 230;

/// The settings of a domain as Cyclone DDS reads them: ours, then `user_configuration` (the value of CYCLONEDDS_URI:
/// file names and XML, separated by commas), whose elements win. Refuses a peer that is not a host name or an address.
[[nodiscard]] Result<std::string> domain_configuration(const std::vector<std::string>& peers,
                                                       const std::string& user_configuration);

/// A participant in a DDS domain with our settings. A domain exists once in a process and is configured by whoever
/// creates it first, so the links of a process share it: it goes with the last of them. Any thread.
class Domain {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Domain>> join(unsigned number, const std::vector<std::string>& peers);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  [[nodiscard]] dds_entity_t participant() const { return participant_; }

 private:
  Domain(unsigned number, dds_entity_t participant) : number_{number}, participant_{participant} {}

  unsigned number_;
  dds_entity_t participant_;
};

}  // namespace meshloop

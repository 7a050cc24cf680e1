#include "common/transport/domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>

namespace meshloop {
namespace {

// Messages fit one packet of any network, because large datagrams stall under loss. Discovery asks by multicast and,
// where there is none (loopback alone, most containers), the first 20 processes of this machine and of each peer. Data
// is never multicast: Wi-Fi sends multicast slowly and unacknowledged.
constexpr std::string_view kSettings = R"(<CycloneDDS xmlns="https://cdds.io/config"><Domain Id="any">
<General><AllowMulticast>spdp</AllowMulticast>
<MaxMessageSize>1300B</MaxMessageSize><FragmentSize>1200B</FragmentSize></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>19</MaxAutoParticipantIndex>
<Peers>{}</Peers><SPDPInterval>1s</SPDPInterval><LeaseDuration>10s</LeaseDuration></Discovery>
<Internal><NackDelay>30ms</NackDelay><DefragReliableMaxSamples>256</DefragReliableMaxSamples></Internal>
</Domain></CycloneDDS>)";

bool is_host(std::string_view peer) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view{".-_:[]%"}.find(c) != std::string_view::npos;
  };
  return !peer.empty() && peer.size() <= 255 && std::all_of(peer.begin(), peer.end(), allowed);
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::vector<std::string> with_peers_of_environment(std::vector<std::string> peers) {
  const std::string more = environment("MESHLOOP_PEERS");
  for (std::size_t at = 0; at < more.size();) {
    const std::size_t end = std::min(more.find(',', at), more.size());
    if (end > at) peers.push_back(more.substr(at, end - at));
    at = end + 1;
  }
  return peers;
}

// The domains of this process. DDS itself keeps them process-wide and lets nobody share one that another configured, so
// this count of its users has to be process-wide too.
struct Registry {
  struct Shared {
    dds_entity_t domain = 0;
    int users = 0;
  };
  std::mutex mutex;
  std::map<unsigned, Shared> domains;
};

Registry& registry() {
  static Registry the_registry;
  return the_registry;
}

Status use_domain(Registry& all, unsigned number, const std::vector<std::string>& peers) {
  auto& shared = all.domains[number];
  if (shared.users == 0) {
    const auto settings = domain_configuration(with_peers_of_environment(peers), environment("CYCLONEDDS_URI"));
    if (!settings) return fail(settings.error());
    shared.domain = dds_create_domain(number, settings->c_str());
    if (shared.domain < 0) {
      return fail(
          fmt::format("DDS cannot use the network on domain {} ({}): check that a network interface is up (ip link "
                      "set lo up) and that CYCLONEDDS_URI, if set, holds valid settings",
                      number, dds_strretcode(shared.domain)));
    }
  }
  ++shared.users;
  return {};
}

void leave_domain(Registry& all, unsigned number) {
  auto& shared = all.domains[number];
  if (--shared.users > 0) return;
  dds_delete(shared.domain);
  all.domains.erase(number);
}

}  // namespace

Result<std::string> domain_configuration(const std::vector<std::string>& peers, const std::string& user_configuration) {
  std::string elements = R"(<Peer Address="127.0.0.1"/>)";
  for (const auto& peer : peers) {
    if (!is_host(peer)) {
      return fail(
          fmt::format("the peer '{}' is not a host name or address, as in 192.168.1.5 or station.local:7410", peer),
          ErrorKind::usage);
    }
    elements += fmt::format(R"(<Peer Address="{}"/>)", peer);
  }
  std::string settings = fmt::format(kSettings, elements);
  if (!user_configuration.empty()) settings += "," + user_configuration;
  return settings;
}

Result<std::unique_ptr<Domain>> Domain::join(unsigned number, const std::vector<std::string>& peers) {
  if (number > kHighestDomain) {
    return fail(fmt::format("domain {} does not exist: choose 0 to {}", number, kHighestDomain), ErrorKind::usage);
  }
  auto& all = registry();
  const std::scoped_lock lock{all.mutex};
  if (auto used = use_domain(all, number, peers); !used) return fail(used.error());
  const dds_entity_t participant = dds_create_participant(number, nullptr, nullptr);
  if (participant < 0) {
    leave_domain(all, number);
    return fail(
        fmt::format("DDS refused to create a participant on domain {}: {}", number, dds_strretcode(participant)));
  }
  return std::unique_ptr<Domain>(new Domain(number, participant));
}

Domain::~Domain() {
  auto& all = registry();
  const std::scoped_lock lock{all.mutex};
  dds_delete(participant_);
  leave_domain(all, number_);
}

}  // namespace meshloop

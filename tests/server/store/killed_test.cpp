// kill -9 at random moments: what was reported is there, and the scene opens.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <new>
#include <optional>
#include <random>
#include <thread>

#include "common/base/hash.h"
#include "sanitized.h"
#include "scenes.h"

namespace meshloop {
namespace {

using test::add;

constexpr int kKills = test::kSanitized ? 40 : 200;
/// A scene grows for so many lives, then a new one is made: the checks look at all that a scene ever reported.
constexpr int kLivesOfAScene = 10;

/// What a child is at. The parent reads it from shared memory once the child is dead.
enum class Doing {
  nothing,
  opening,
  committing,
  syncing,
  undoing,
  redoing,
  restoring,
  reporting,
  closing,
  remembering,
  end
};
constexpr auto kDoings = static_cast<std::size_t>(Doing::end);
constexpr std::array<const char*, kDoings> kNames{"nothing", "opening",   "committing", "syncing", "undoing",
                                                  "redoing", "restoring", "reporting",  "closing", "remembering"};

/// One write of a pipe, which comes whole or not at all.
struct Report {
  Revision revision = 0;
  Hash content{};
};

/// Names all bits of a model but its revision.
Hash content_of(const Model& model) {
  std::vector<std::byte> bytes;
  const auto append = [&bytes](const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), first, first + size);
  };
  for (const auto& node : model.nodes) {
    const Hash geometry = content_hash(*node.submesh);
    append(&node.id, sizeof node.id);
    append(node.name.c_str(), node.name.size() + 1);
    append(node.T_world_node.data(), 16 * sizeof(double));
    append(geometry.data(), geometry.size());
  }
  return hash_of(bytes);
}

/// The life of one process that changes a scene until it is killed.
class Child {
 public:
  Child(const std::filesystem::path& scene, unsigned seed, int out, std::atomic<Doing>& doing)
      : scene_{scene}, random_{seed}, out_{out}, doing_{&doing} {}

  [[noreturn]] void live() {
    for (;;) {
      doing_->store(Doing::opening);
      auto store = SceneStore::open(scene_, true);
      if (!store) ::_exit(1);
      for (int i = 0; i < 8; ++i) change(**store);
      doing_->store(Doing::closing);
    }
  }

 private:
  void change(SceneStore& store) {
    auto model = one_change(store);
    if (!model) return;  // nothing to undo, redo or restore: not a change
    doing_->store(Doing::syncing);
    if (!store.sync()) ::_exit(2);
    doing_->store(Doing::reporting);
    const Report report{(*model)->revision, content_of(**model)};
    if (::write(out_, &report, sizeof report) != sizeof report) ::_exit(3);
  }

  Result<std::shared_ptr<const Model>> one_change(SceneStore& store) {
    switch (random_() % 8) {
      case 0:
        doing_->store(Doing::undoing);
        return store.undo("child");
      case 1:
        doing_->store(Doing::redoing);
        return store.redo("child");
      case 2:
        doing_->store(Doing::restoring);
        return store.restore(random_() % (store.model()->revision + 1), "child");
      default:
        return commit(store);
    }
  }

  Result<std::shared_ptr<const Model>> commit(SceneStore& store) {
    const int seed = static_cast<int>(random_() % 1000);
    std::vector<Edit> edits{add(store.next_node_id(), seed, 12)};
    const auto model = store.model();
    if (!model->nodes.empty()) {
      const NodeId id = model->nodes[random_() % model->nodes.size()].id;
      edits.push_back(MoveNode{id, make_pose({seed * 0.1, 0, 0}, Eigen::Quaterniond::Identity())});
    }
    if (model->nodes.size() > 3) edits.push_back(RemoveNode{model->nodes.front().id});
    RevisionInfo info;
    info.proposals = remember(store, seed);
    info.snapshot = SnapshotInfo{"rig " + std::to_string(seed % 3), {}, std::nullopt};
    info.snapshot->depth_pose.state = TrackState::tracking;
    doing_->store(Doing::committing);
    const auto committed = seed % 2 == 0 ? store.commit(edits, info) : store.commit_unsynced(edits, info);
    if (!committed) ::_exit(4);
    return committed;
  }

  /// Two proposals, of which the change accepts one; the other is rejected at times.
  std::vector<AcceptedProposal> remember(SceneStore& store, int seed) {
    ProposalContent content;
    content.effect = "seed " + std::to_string(seed);
    content.box_m.extend(Eigen::Vector3d{1, 2, seed * 1.0});
    content.box_m.extend(Eigen::Vector3d{2, 3, seed + 1.0});
    doing_->store(Doing::remembering);
    const ProposalSighting sighting{std::nullopt, std::nullopt, content};
    const auto ids = store.remember({sighting, sighting});
    if (!ids || (seed % 3 == 0 && !store.reject({ids->back()}, "child", "seed"))) ::_exit(5);
    return {{ids->front(), content}};
  }

  std::filesystem::path scene_;
  std::mt19937 random_;
  int out_;
  std::atomic<Doing>* doing_;
};

class Killed : public test::SceneFolder {
 protected:
  Killed() {
    void* page = ::mmap(nullptr, sizeof *doing_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (page == MAP_FAILED) throw std::runtime_error("no shared memory");
    doing_ = new (page) std::atomic<Doing>{Doing::nothing};
  }
  ~Killed() override { ::munmap(doing_, sizeof *doing_); }

  /// A life that ends after so many reports and the delay; notes what was reported.
  void live_and_die(unsigned seed, int reports, std::chrono::microseconds delay) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    doing_->store(Doing::nothing);
    const pid_t child = ::fork();
    if (child == 0) Child{scene_, seed, ends[1], *doing_}.live();
    ::close(ends[1]);
    for (int i = 0; i < reports; ++i) note_report(ends[0]);
    std::this_thread::sleep_for(delay);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    while (note_report(ends[0])) {
    }
    ::close(ends[0]);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself, with " << WEXITSTATUS(status);
    ++killed_while_[static_cast<std::size_t>(doing_->load())];
  }

  /// The scene opens, has every revision that it ever reported, with its content, and perhaps one more.
  void check() {
    if (reported_.empty() && !std::filesystem::exists(scene_)) return;
    const auto store = SceneStore::open(scene_, false);
    ASSERT_TRUE(store) << store.error().message;
    const Revision last = (*store)->model()->revision;
    const Revision reported = reported_.empty() ? 0 : reported_.rbegin()->first;
    ASSERT_GE(last, reported);
    ASSERT_LE(last, std::max(reported, last_) + 1) << "what was not reported is one change";
    const auto log = (*store)->log();
    ASSERT_TRUE(log) << log.error().message;
    ASSERT_EQ(log->size(), last);
    for (const auto& [revision, content] : reported_) {
      const auto model = (*store)->model_at(revision);
      ASSERT_TRUE(model) << model.error().message;
      ASSERT_EQ(content_of(**model), content) << "revision " << revision;
    }
    check_proposals(**store, *log);
    last_ = last;
  }

  /// A proposal is accepted exactly when the revision that says so is there and is not undone.
  static void check_proposals(const SceneStore& store, const std::vector<RevisionInfo>& log) {
    const auto records = store.proposals();
    ASSERT_TRUE(records) << records.error().message;
    std::map<ProposalId, Revision> accepted_by;
    for (const auto& info : log) {
      for (const auto& [id, content] : info.proposals) {
        ASSERT_TRUE(accepted_by.emplace(id, info.revision).second) << "accepted twice";
        ASSERT_LE(id, records->size());
        ASSERT_EQ((*records)[id - 1].content.effect, content.effect);
      }
    }
    for (std::size_t i = 0; i < records->size(); ++i) {
      const ProposalRecord& record = (*records)[i];
      ASSERT_EQ(record.id, i + 1) << "an id is left out or given twice";
      const auto found = accepted_by.find(record.id);
      ASSERT_EQ(record.revision.has_value(), found != accepted_by.end());
      if (record.revision) {
        ASSERT_EQ(*record.revision, found->second);
      }
    }
  }

  std::size_t kills_while(Doing doing) const { return killed_while_[static_cast<std::size_t>(doing)]; }
  std::string kills() const {
    std::map<std::string, std::size_t> counts;
    for (std::size_t i = 0; i < kDoings; ++i) counts[kNames[i]] = killed_while_[i];
    return fmt::format("{}", counts);
  }

  std::map<Revision, Hash> reported_;
  /// When the scene was last looked at.
  Revision last_ = 0;

 private:
  bool note_report(int from) {
    Report report;
    if (::read(from, &report, sizeof report) != sizeof report) return false;
    reported_[report.revision] = report.content;
    return true;
  }

  std::atomic<Doing>* doing_ = nullptr;
  std::array<std::size_t, kDoings> killed_while_{};
};

TEST_F(Killed, LosesNoReportedRevisionAndAlwaysLeavesASceneThatOpens) {
  std::mt19937 random{21};
  std::size_t revisions = 0;
  for (int life = 0; life < kKills; ++life) {
    if (life % kLivesOfAScene == 0) {
      scene_ = folder_ / fmt::format("{}.scene", life);
      reported_.clear();
      last_ = 0;
    }
    // Every third one is hit around its start; the others in the midst of their work.
    const int reports = life % 3 == 0 ? 0 : static_cast<int>(random() % 6);
    const std::chrono::microseconds delay{random() % 12'000};
    live_and_die(static_cast<unsigned>(life), reports, delay);
    ASSERT_FALSE(HasFatalFailure());
    check();
    ASSERT_FALSE(HasFatalFailure()) << "life " << life << ", delay " << delay.count() << " us";
    if (life % kLivesOfAScene == kLivesOfAScene - 1) revisions += reported_.size();
  }
  RecordProperty("kills", kills());
  EXPECT_GT(revisions, static_cast<std::size_t>(kKills)) << "the children hardly changed anything";
  if (test::kSanitized) return;  // too few kills to hit everything
  for (const Doing doing : {Doing::opening, Doing::committing, Doing::undoing}) {
    EXPECT_GT(kills_while(doing), 0u) << kills();
  }
}

}  // namespace
}  // namespace meshloop

#include "server/store/scene_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>

#include "common/base/clock.h"
#include "server/store/file_identity.h"
#include "server/store/journal.h"
#include "server/store/model_rows.h"
#include "server/store/proposal_rows.h"
#include "server/store/returns.h"
#include "server/store/schema.h"
#include "server/store/writer_lock.h"

namespace meshloop {
namespace {

constexpr std::string_view kEpoch = "epoch";
constexpr std::string_view kNextNodeId = "next_node_id";
constexpr NodeId kLargestId = static_cast<NodeId>(std::numeric_limits<std::int64_t>::max() - 1);

class SqliteSceneStore final : public SceneStore {
 public:
  SqliteSceneStore(Database database, FileIdentity identity, std::shared_ptr<const Model> model, NodeId next_node_id)
      : database_{std::move(database)},
        identity_{std::move(identity)},
        model_{std::move(model)},
        next_node_id_{next_node_id} {}

  std::shared_ptr<const Model> model() const override {
    const std::scoped_lock lock{mutex_};
    return model_;
  }
  NodeId next_node_id() const override {
    const std::scoped_lock lock{mutex_};
    return next_node_id_;
  }

  Result<std::shared_ptr<const Model>> commit(const std::vector<Edit>& edits, RevisionInfo info) override;
  Result<std::shared_ptr<const Model>> commit_unsynced(const std::vector<Edit>& edits, RevisionInfo info) override;
  Status sync() override;
  Result<std::shared_ptr<const Model>> undo(const std::string& author) override {
    return go_back_or_forth(true, author);
  }
  Result<std::shared_ptr<const Model>> redo(const std::string& author) override {
    return go_back_or_forth(false, author);
  }
  Result<std::shared_ptr<const Model>> restore(Revision revision, const std::string& author) override;
  Result<std::optional<Revision>> shown_by_undo() const override { return shown_by(true); }
  Result<std::optional<Revision>> shown_by_redo() const override { return shown_by(false); }
  Result<std::vector<RevisionInfo>> log() const override;
  Result<std::shared_ptr<const Model>> model_at(Revision revision) const override;
  Result<std::vector<ProposalRecord>> proposals() const override;
  Result<std::vector<ProposalId>> remember(const std::vector<ProposalSighting>& seen) override;
  Status reject(const std::vector<ProposalId>& ids, const std::string& author, const std::string& reason) override;
  Result<std::uint64_t> begin_epoch() override;

 private:
  enum class Syncing { now, later };
  struct Writing {
    Transaction transaction;
    /// The present revision.
    Place here;
    Syncing syncing;
  };
  /// Takes the right to write, and checks that this store still shows the last revision.
  Result<Writing> begin_writing(Syncing syncing = Syncing::now);
  Result<std::shared_ptr<const Model>> go_back_or_forth(bool back, const std::string& author);
  Result<std::optional<Revision>> shown_by(bool back) const;
  Result<std::shared_ptr<const Model>> commit_locked(const std::vector<Edit>& edits, RevisionInfo info,
                                                     Syncing syncing);
  Result<std::shared_ptr<const Model>> write(Writing writing, Model after, JournalEntry entry, NodeId next_node_id);
  /// What a revision means for the proposals that a change accepted, its own or those of the one that it shows again.
  Status change_proposals(const JournalEntry& entry);
  Status finish(Writing& writing);
  /// After a reading.
  Status check_nothing_changed() const {
    return database_.access() == Database::Access::unlogged ? identity_.check_content() : Status{};
  }
  /// The edits with hashes that are right whatever the caller filled in, and the first free id after them.
  Result<std::vector<Edit>> checked(std::vector<Edit> edits, NodeId& next_node_id) const;

  mutable std::mutex mutex_;
  mutable Database database_;
  FileIdentity identity_;
  std::optional<WriterLock> writer_;
  std::shared_ptr<const Model> model_;
  NodeId next_node_id_ = 1;
  /// Something was committed, by this process or one that died, that the disk may not have.
  bool is_unsynced_ = true;
  /// Why a sync failed.
  std::optional<Error> broken_;
};

Result<SqliteSceneStore::Writing> SqliteSceneStore::begin_writing(Syncing syncing) {
  if (broken_) return fail(*broken_);
  if (auto same = identity_.check(); !same) return fail(same.error());
  if (!writer_) {
    auto lock = WriterLock::take(database_.file());
    if (!lock) return fail(lock.error());
    writer_.emplace(std::move(*lock));
  }
  if (auto ok = database_.sync_commits(syncing == Syncing::now); !ok) return fail(ok.error());
  auto transaction = Transaction::begin(database_, "BEGIN IMMEDIATE");
  if (!transaction) return fail(transaction.error());
  const auto last = last_place(database_);
  if (!last) return fail(last.error());
  if (last->revision != model_->revision) {
    return fail(fmt::format("another program has changed '{}' meanwhile (revision {} became {}); open it again",
                            database_.file().string(), model_->revision, last->revision));
  }
  return Writing{std::move(*transaction), *last, syncing};
}

Status SqliteSceneStore::finish(Writing& writing) {
  if (auto ok = writing.transaction.commit(); !ok) return ok;
  // A commit that waits brings the whole log to the disk.
  is_unsynced_ = writing.syncing == Syncing::later;
  return {};
}

Result<std::vector<Edit>> SqliteSceneStore::checked(std::vector<Edit> edits, NodeId& next_node_id) const {
  for (auto& edit : edits) {
    auto* added = std::get_if<AddNode>(&edit);
    if (added == nullptr || !added->node.submesh) continue;
    const NodeId id = added->node.id;
    if (id != 0 && id < next_node_id_) {
      return fail(fmt::format("node id {} was used before; ids from {} on are free", id, next_node_id_));
    }
    if (id > kLargestId) return fail(fmt::format("node id {} is too large", id));
    added->node.hash = content_hash(*added->node.submesh);
    next_node_id = std::max(next_node_id, id + 1);
  }
  return edits;
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::write(Writing writing, Model after, JournalEntry entry,
                                                             NodeId next_node_id) {
  entry.info.revision = entry.place.revision = after.revision;
  entry.info.parent = model_->revision;
  if (entry.info.accepted_ns == 0) entry.info.accepted_ns = wall_clock_ns();
  if (auto ok = bring_up_to_date(database_); !ok) return fail(ok.error());
  // The journal first: the rows of nodes refer to it.
  if (auto ok = append_entry(database_, entry); !ok) return fail(ok.error());
  if (auto ok = change_proposals(entry); !ok) return fail(ok.error());
  if (auto ok = write_difference(database_, *model_, after); !ok) return fail(ok.error());
  if (auto ok = write_counter(database_, kNextNodeId, next_node_id); !ok) return fail(ok.error());
  if (auto ok = finish(writing); !ok) return fail(ok.error());
  model_ = std::make_shared<const Model>(std::move(after));
  next_node_id_ = next_node_id;
  return model_;
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::commit(const std::vector<Edit>& edits, RevisionInfo info) {
  const std::scoped_lock lock{mutex_};
  return commit_locked(edits, std::move(info), Syncing::now);
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::commit_unsynced(const std::vector<Edit>& edits,
                                                                       RevisionInfo info) {
  const std::scoped_lock lock{mutex_};
  return commit_locked(edits, std::move(info), Syncing::later);
}

Status SqliteSceneStore::change_proposals(const JournalEntry& entry) {
  const RevisionInfo& info = entry.info;
  return entry.undoes   ? reopen_proposals(database_, *entry.undoes, info.author, info.accepted_ns)
         : entry.redoes ? close_proposals_again(database_, *entry.redoes)
                        : accept_proposals(database_, info.revision, info.author, info.accepted_ns, info.proposals);
}

Status SqliteSceneStore::sync() {
  const std::scoped_lock lock{mutex_};
  if (broken_) return fail(*broken_);
  if (!is_unsynced_) return {};
  if (auto ok = database_.sync(); !ok) {
    broken_ = ok.error();
    return ok;
  }
  is_unsynced_ = false;
  return {};
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::commit_locked(const std::vector<Edit>& edits, RevisionInfo info,
                                                                     Syncing syncing) {
  NodeId next_node_id = next_node_id_;
  const auto usable = checked(edits, next_node_id);
  if (!usable) return fail(usable.error());
  auto after = apply(*model_, *usable, model_->revision + 1);
  if (!after) return fail(after.error());
  auto writing = begin_writing(syncing);
  if (!writing) return fail(writing.error());
  JournalEntry entry{std::move(info), {after->revision, after->revision, writing->here.content, std::nullopt}};
  return write(std::move(*writing), std::move(*after), std::move(entry), next_node_id);
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::go_back_or_forth(bool back, const std::string& author) {
  const std::scoped_lock lock{mutex_};
  auto writing = begin_writing();
  if (!writing) return fail(writing.error());
  const auto& target = back ? writing->here.undo_content : writing->here.redo_revision;
  if (!target) return fail(back ? "there is nothing to undo" : "there is nothing to redo");
  auto place = place_of(database_, *target);
  if (!place) return fail(place.error());
  const auto change = read_info(database_, back ? writing->here.content : place->content);
  if (!change) return fail(change.error());
  if (back) place->redo_revision = writing->here.revision;
  auto after = read_model(database_, *target, *model_);
  if (!after) return fail(after.error());
  after->revision = model_->revision + 1;
  JournalEntry entry{back ? info_of_undo(*change, author) : info_of_redo(*change, author), *place};
  (back ? entry.undoes : entry.redoes) = change->revision;
  return write(std::move(*writing), std::move(*after), std::move(entry), next_node_id_);
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::restore(Revision revision, const std::string& author) {
  const std::scoped_lock lock{mutex_};
  auto writing = begin_writing();
  if (!writing) return fail(writing.error());
  if (const auto place = place_of(database_, revision); !place) return fail(place.error());
  auto after = read_model(database_, revision, *model_);
  if (!after) return fail(after.error());
  if (same_content(*after, *model_)) {
    return fail(fmt::format("the scene is as it was at revision {} already", revision));
  }
  after->revision = model_->revision + 1;
  JournalEntry entry{info_of_restore(revision, *model_, *after, author),
                     {after->revision, after->revision, writing->here.content, std::nullopt}};
  return write(std::move(*writing), std::move(*after), std::move(entry), next_node_id_);
}

Result<std::optional<Revision>> SqliteSceneStore::shown_by(bool back) const {
  const std::scoped_lock lock{mutex_};
  const auto snapshot = Transaction::begin(database_, "BEGIN");
  if (!snapshot) return fail(snapshot.error());
  const auto here = place_of(database_, model_->revision);
  if (auto same = check_nothing_changed(); !same) return fail(same.error());
  if (!here) return fail(here.error());
  return back ? here->undo_content : here->redo_revision;
}

Result<std::vector<RevisionInfo>> SqliteSceneStore::log() const {
  const std::scoped_lock lock{mutex_};
  const auto snapshot = Transaction::begin(database_, "BEGIN");
  if (!snapshot) return fail(snapshot.error());
  auto journal = read_journal(database_);
  if (auto same = check_nothing_changed(); !same) return fail(same.error());
  return journal;
}

Result<std::shared_ptr<const Model>> SqliteSceneStore::model_at(Revision revision) const {
  const std::scoped_lock lock{mutex_};
  const auto snapshot = Transaction::begin(database_, "BEGIN");
  if (!snapshot) return fail(snapshot.error());
  const auto place = place_of(database_, revision);
  auto model = place ? read_model(database_, revision, *model_) : Result<Model>{fail(place.error())};
  if (auto same = check_nothing_changed(); !same) return fail(same.error());
  if (!model) return fail(model.error());
  return std::make_shared<const Model>(std::move(*model));
}

Result<std::vector<ProposalRecord>> SqliteSceneStore::proposals() const {
  const std::scoped_lock lock{mutex_};
  const auto snapshot = Transaction::begin(database_, "BEGIN");
  if (!snapshot) return fail(snapshot.error());
  const auto there = has_proposals(database_);
  if (!there) return fail(there.error());
  auto records = *there ? read_proposals(database_) : Result<std::vector<ProposalRecord>>{};
  if (auto same = check_nothing_changed(); !same) return fail(same.error());
  return records;
}

Result<std::vector<ProposalId>> SqliteSceneStore::remember(const std::vector<ProposalSighting>& seen) {
  const std::scoped_lock lock{mutex_};
  auto writing = begin_writing(Syncing::later);
  if (!writing) return fail(writing.error());
  if (auto ok = bring_up_to_date(database_); !ok) return fail(ok.error());
  auto ids = remember_proposals(database_, seen, wall_clock_ns());
  if (!ids) return ids;
  if (auto ok = finish(*writing); !ok) return fail(ok.error());
  return ids;
}

Status SqliteSceneStore::reject(const std::vector<ProposalId>& ids, const std::string& author,
                                const std::string& reason) {
  const std::scoped_lock lock{mutex_};
  auto writing = begin_writing();
  if (!writing) return fail(writing.error());
  if (auto ok = bring_up_to_date(database_); !ok) return ok;
  if (auto ok = reject_proposals(database_, ids, author, reason, wall_clock_ns()); !ok) return ok;
  return finish(*writing);
}

Result<std::uint64_t> SqliteSceneStore::begin_epoch() {
  const std::scoped_lock lock{mutex_};
  auto writing = begin_writing();
  if (!writing) return fail(writing.error());
  const auto epoch = read_counter(database_, kEpoch);
  if (!epoch) return fail(epoch.error());
  if (auto ok = write_counter(database_, kEpoch, *epoch + 1); !ok) return fail(ok.error());
  if (auto ok = finish(*writing); !ok) return fail(ok.error());
  return *epoch + 1;
}

struct State {
  Model model;
  NodeId next_node_id = 1;
};

Result<State> read_state(Database& database) {
  const auto snapshot = Transaction::begin(database, "BEGIN");
  if (!snapshot) return fail(snapshot.error());
  const auto last = last_place(database);
  if (!last) return fail(last.error());
  const auto next_node_id = read_counter(database, kNextNodeId);
  if (!next_node_id) return fail(next_node_id.error());
  auto model = read_model(database, last->revision, Model{});
  if (!model) return fail(model.error());
  if (*next_node_id == 0 || (!model->nodes.empty() && model->nodes.back().id >= *next_node_id)) {
    return fail(
        fmt::format("'{}' is damaged (its next node id is in use); restore it from a copy", database.file().string()));
  }
  return State{std::move(*model), *next_node_id};
}

}  // namespace

Result<std::unique_ptr<SceneStore>> SceneStore::open(const std::filesystem::path& file, bool create) {
  if (auto ok = make_sure_it_is_there(file, create); !ok) return fail(ok.error());
  auto identity = FileIdentity::of(file);
  if (!identity) return fail(identity.error());
  auto database = open_scene_file(file);
  if (!database) return fail(database.error());
  auto state = read_state(*database);
  if (database->access() == Database::Access::unlogged) {
    if (auto same = identity->check_content(); !same) return fail(same.error());
  }
  if (!state) return fail(state.error());
  database->checkpoint_on_close(true);
  return std::make_unique<SqliteSceneStore>(std::move(*database), std::move(*identity),
                                            std::make_shared<const Model>(std::move(state->model)),
                                            state->next_node_id);
}

}  // namespace meshloop

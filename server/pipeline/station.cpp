#include "server/pipeline/station.h"

#include <fmt/format.h>

#include <unistd.h>

#include <chrono>
#include <iostream>
#include <thread>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/image/image_file.h"
#include "common/program/stop_signal.h"
#include "server/pipeline/event_text.h"
#include "server/pipeline/proposal_pictures.h"
#include "server/pipeline/result_json.h"
#include "server/pipeline/station_parts.h"

namespace meshloop {

Station::Station(std::unique_ptr<Parts> parts) : parts_{std::move(parts)} {}
Station::~Station() = default;

Result<std::unique_ptr<Station>> Station::create(const StationOptions& options, const Rig& rig) {
  if (!options.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(fmt::format("cannot make the folder '{}': {}", options.out.string(), error.message()));
  }
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto examiner = Examiner::create(rig, options.examiner);
  if (!examiner) return fail(examiner.error());
  auto views = Views::create(**gpu, rig, options.views);
  if (!views) return fail(views.error());
  auto store = SceneStore::open(options.scene, false);
  if (!store) return fail(store.error());
  const auto epoch = (*store)->begin_epoch();
  if (!epoch) return fail(epoch.error());
  auto writer = SceneWriter::create(options.link);
  if (!writer) return fail(writer.error());
  std::unique_ptr<Parts> parts{new Parts{.options = options,
                                         .rig = rig,
                                         .gpu = std::move(*gpu),
                                         .examiner = std::move(*examiner),
                                         .views = std::move(*views),
                                         .store = std::move(*store),
                                         .publisher = Publisher{std::move(*writer), *epoch},
                                         .previous_pose = std::nullopt,
                                         .after_is_due = false,
                                         .last_publish = {},
                                         .unpublished_ns = std::nullopt,
                                         .region_pictures = RegionPictures{options.out},
                                         .recent = RecentDepths{static_cast<std::size_t>(options.frames_fused)},
                                         .in_flight = nullptr,
                                         .commands = CommandLines{options.commands ? STDIN_FILENO : -1},
                                         .offer = std::nullopt,
                                         .offered_regions = {},
                                         .looked = std::nullopt,
                                         .trust = {},
                                         .tally = {},
                                         .first_revision = 0}};
  std::unique_ptr<Station> station{new Station{std::move(parts)}};
  const auto model = station->parts_->store->model();
  station->parts_->first_revision = model->revision;
  if (auto done = station->publish(model, wall_clock_ns()); !done) return fail(done.error());
  station->tell({{"event", "serving"}, {"scene", options.link.scene}, {"revision", model->revision}});
  return station;
}

void Station::tell(nlohmann::json event) const {
  // Flushed: whoever reads this acts on it.
  std::cout << (parts_->options.json ? json_line(event) : event_text(event)) << std::endl;
}

Status Station::publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns) {
  parts_->last_publish = {};
  auto report = parts_->publisher.publish(model, accepted_ns);
  if (!report) return fail("publishing", report.error());
  parts_->last_publish = *report;
  return {};
}

void Station::publish_or_retry(std::int64_t accepted_ns) {
  const auto done = publish(parts_->store->model(), accepted_ns);
  if (!done) log_warning("{}; the revision is kept, and will be sent again", done.error().message);
  parts_->unpublished_ns = done ? std::nullopt : std::optional{accepted_ns};
}

ColorImage Station::draw_color(const TrackedFrame& tracked, const Examination& examination, const std::string& title,
                               const Framing* framing) {
  auto picture = parts_->views.on_color(tracked, examination, title, framing);
  if (picture) return std::move(*picture);
  log_warning("{}; going on without the picture", picture.error().message);
  return {};
}

// `color` is the picture over colour where it has been drawn already.
void Station::write_pictures(const char* when, Revision revision, const TrackedFrame& tracked,
                             const Examination& examination, const ColorImage* color) {
  if (parts_->options.out.empty()) return;
  const auto title = fmt::format("frame {}, {} revision {}, {}", tracked.frame.index, when, revision,
                                 smallest_change_text(examination));
  const auto write = [&](const char* kind, const ColorImage& picture) {
    if (picture.empty()) return;
    const auto file = parts_->options.out / fmt::format("revision_{:04}_{}{}.png", revision, when, kind);
    if (auto done = write_png(file, picture); !done) log_warning("{}; going on without it", done.error().message);
  };
  if (parts_->views.wants_color())
    write("", color != nullptr ? *color : draw_color(tracked, examination, title, nullptr));
  if (parts_->views.wants_depth()) write("_depth", parts_->views.on_depth(tracked, examination, title));
}

nlohmann::json Station::confirmed_json(const TrackedFrame& tracked, const Examination& examination) {
  auto& pictures = parts_->region_pictures;
  if (!parts_->options.out.empty()) {
    if (auto done = pictures.update(tracked, examination, parts_->views, true); !done) {
      log_warning("{}; going on without it", done.error().message);
    }
  }
  nlohmann::json regions = nlohmann::json::array();
  for (const auto& region : examination.regions.regions) {
    if (!region.confirmed) continue;
    regions.push_back(region_json(region));
    if (const auto file = pictures.file_of(region.id); !file.empty()) regions.back()["picture"] = file;
  }
  return regions;
}

Result<Station::Change> Station::change(const Offer& offer, const std::vector<Offered>& accepted,
                                        const std::string& author) {
  const TrackedFrame& tracked = offer.tracked;
  const Examination& examination = offer.examination;
  Change change;
  change.offer = &offer;
  const auto title = fmt::format("frame {}, before revision {}, {}", tracked.frame.index,
                                 parts_->store->model()->revision + 1, smallest_change_text(examination));
  const auto framing = framing_of(examination.regions, offer.proposals);
  change.picture = draw_color(tracked, examination, title, &framing);
  const Evidence evidence{author, snapshot_info(tracked, offer.registration, parts_->options.calibration),
                          change.picture};
  auto acceptance = accept_changes(*parts_->store, accepted, evidence);
  if (!acceptance) return fail("accepting", acceptance.error());
  publish_or_retry(acceptance->info.accepted_ns);
  change.acceptance = std::move(*acceptance);
  change.published = parts_->last_publish;
  change.is_published = !parts_->unpublished_ns;
  parts_->examiner.model_changed();
  parts_->looked.reset();
  return change;
}

Status Station::accept(const Offer& offer, const std::vector<Offered>& accepted, const std::string& author) {
  auto done = change(offer, accepted, author);
  if (!done) return fail(done.error());
  return conclude({std::move(*done)});
}

Status Station::conclude(const std::vector<Change>& changes) {
  // The report promises that the revision will be there whatever happens; devices need not wait for that.
  const Stopwatch watch;
  if (auto synced = parts_->store->sync(); !synced) {
    return fail(
        fmt::format("revision {} was accepted, but may be gone at the next start", parts_->store->model()->revision),
        synced.error());
  }
  for (const auto& change : changes) tell_revision(change, watch.milliseconds());
  for (const auto& change : changes) {
    const Offer& offer = *change.offer;
    write_pictures("before", change.acceptance.info.revision, offer.tracked, offer.examination, &change.picture);
  }
  parts_->after_is_due = true;
  return {};
}

void Station::tell_revision(const Change& change, double sync_ms) const {
  const Offer& offer = *change.offer;
  const auto& info = change.acceptance.info;
  nlohmann::json moves = nlohmann::json::array();
  for (const auto& move : change.acceptance.moves) moves.push_back(move_json(move));
  nlohmann::json ids = nlohmann::json::array();
  for (const auto& proposal : info.proposals) ids.push_back(proposal.id);
  tell({{"event", "revision"},
        {"revision", info.revision},
        {"frame", offer.tracked.frame.index},
        {"accepted_ns", info.accepted_ns},
        {"triangles_added", info.triangles_added},
        {"triangles_removed", info.triangles_removed},
        {"triangles", change.acceptance.model->triangle_count()},
        {"published", change.is_published},
        {"bytes", change.published.bytes},
        {"raw_bytes", change.published.raw_bytes},
        {"devices", parts_->publisher.readers()},
        {"summary", info.summary},
        {"proposals", ids},
        {"registration", registration_json(offer.registration, offer.tracked.depth_pose)},
        {"edge_rings", rings_json(offer.rings)},
        {"joint_poses", joint_json(offer.joint)},
        {"frames_fused", offer.frames},
        {"moves", moves},
        {"time_ms",
         {{"snapshot", offer.snapshot_ms},
          {"commit", change.acceptance.commit_ms},
          {"encode", change.published.encode_ms},
          {"sync", sync_ms}}}});
}

void Station::begin(TrackedFrame tracked) {
  if (parts_->unpublished_ns) publish_or_retry(*parts_->unpublished_ns);
  auto wait = reason_to_wait(tracked, parts_->previous_pose, parts_->rig);
  parts_->previous_pose = tracked.depth_pose;
  if (!wait) parts_->recent.add(tracked);
  nlohmann::json event{{"event", "frame"},
                       {"index", tracked.frame.index},
                       {"timestamp", tracked.frame.depth_timestamp_s},
                       {"state", name_of(tracked.color_pose.state)},
                       {"track_ms", tracked.track_ms}};
  if (tracked.depth_pose.state == TrackState::lost) return tell(std::move(event));
  parts_->in_flight = std::unique_ptr<InFlight>{new InFlight{.tracked = std::move(tracked),
                                                             .model = parts_->store->model(),
                                                             .event = std::move(event),
                                                             .wait = std::move(wait),
                                                             .begun = std::nullopt}};
  InFlight& frame = *parts_->in_flight;
  frame.begun.emplace(parts_->examiner.begin(frame.tracked, *frame.model));
}

Status Station::finish() {
  if (!parts_->in_flight) return {};
  const auto frame = std::move(parts_->in_flight);
  auto examination = parts_->examiner.finish(std::move(*frame->begun));
  if (!examination) return fail(fmt::format("frame {}", frame->tracked.frame.index), examination.error());
  return finish(*frame, std::move(*examination));
}

Status Station::finish(const InFlight& frame, Examination examination) {
  const TrackedFrame& tracked = frame.tracked;
  nlohmann::json event = frame.event;
  event["counts"] = counts_json(examination.comparison);
  event["time_ms"] = times_json(examination);
  event["smallest_change_m"] = smallest_change_json(examination);
  event["regions"] = confirmed_json(tracked, examination);
  const auto confirmed = event["regions"].size();
  event["confirmed_regions"] = confirmed;
  if (confirmed > 0) parts_->tally.add_confirmed();
  if (confirmed > 0 && frame.wait) {
    parts_->tally.add_waiting();
    event["waits"] = *frame.wait;
  }
  tell(std::move(event));
  if (parts_->after_is_due) {
    parts_->after_is_due = false;
    write_pictures("after", frame.model->revision, tracked, examination, nullptr);
  }
  if (confirmed == 0 || frame.wait) return {};
  return consider(tracked, std::move(examination));
}

Status Station::serve() {
  constexpr double kRetry_ms = 1000;
  const Stopwatch watch;
  double last_try_ms = 0;
  while (!stop_requested() && (parts_->options.serve_s < 0 || watch.milliseconds() < 1000 * parts_->options.serve_s)) {
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
    if (auto done = obey_all(); !done) return done;
    if (!parts_->unpublished_ns || watch.milliseconds() < last_try_ms + kRetry_ms) continue;
    publish_or_retry(*parts_->unpublished_ns);
    last_try_ms = watch.milliseconds();
  }
  return {};
}

void Station::tell_end() const {
  tell({{"event", "end"}, {"revision", parts_->store->model()->revision}, {"changes", parts_->tally.json()}});
  // Whoever is served meanwhile shall not learn it when that ends.
  if (parts_->options.serve_s == 0) return;
  if (const auto used = check_any_used(); !used) log_warning("{}", used.error().message);
}

Status Station::check_any_used() const {
  if (parts_->store->model()->revision != parts_->first_revision || !parts_->tally.is_all_withheld()) return {};
  return fail("no frame could be used; " + parts_->tally.why_withheld());
}

Status Station::run(TrackedFrames& frames) {
  while (!stop_requested()) {
    // The next frame is tracked while this one is compared, if it is there; otherwise nothing shall wait for it.
    if (!frames.ready()) {
      if (auto done = finish(); !done) return done;
    }
    auto tracked = frames.next();
    if (auto done = finish(); !done) return done;
    if (auto done = obey_all(); !done) return done;
    if (!tracked) return fail(tracked.error());
    if (!*tracked || stop_requested()) break;
    begin(std::move(**tracked));
  }
  if (auto done = finish(); !done) return done;
  tell_end();
  if (auto done = serve(); !done) return done;
  return check_any_used();
}

}  // namespace meshloop

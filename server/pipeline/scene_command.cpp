// `scene`: the scene file.
#include <fmt/format.h>

#include <functional>
#include <iostream>
#include <memory>

#include "common/base/clock.h"
#include "common/interchange/model_file.h"
#include "common/program/arguments.h"
#include "common/program/json_output.h"
#include "common/program/model_arguments.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/options.h"
#include "server/pipeline/scene_history.h"

namespace meshloop {
namespace {

struct SceneArguments {
  std::string scene;
  std::string file;
  ModelArguments model;
  std::optional<Revision> revision;  // none: the present one
  std::string pictures;              // folder; none: they are not written
  std::string state = "all";
  OperatorArguments person;
  bool json = false;
};

nlohmann::json model_json(const Model& model) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const auto& node : model.nodes) {
    nodes.push_back({{"id", node.id},
                     {"name", node.name},
                     {"vertices", node.submesh->positions.size()},
                     {"triangles", node.submesh->triangles.size()},
                     {"colors", node.submesh->has_colors()},
                     {"texture_bytes", node.submesh->texture ? node.submesh->texture->jpeg.size() : 0}});
  }
  return {{"revision", model.revision}, {"triangles", model.triangle_count()}, {"nodes", nodes}};
}

void print_model(const SceneArguments& arguments, const Model& model) {
  if (arguments.json) {
    print_json(model_json(model));
    return;
  }
  std::cout << fmt::format("revision {}, {} node{}, {} triangles\n", model.revision, model.nodes.size(),
                           model.nodes.size() == 1 ? "" : "s", model.triangle_count());
  for (const auto& node : model.nodes) {
    std::cout << fmt::format("  {:>4}  {:<24} {:>8} triangles\n", node.id, node.name, node.submesh->triangles.size());
  }
}

Status scene_import(const SceneArguments& arguments) {
  auto imported = arguments.model.import();
  if (!imported) return fail(imported.error());
  auto store = SceneStore::open(arguments.scene, true);
  if (!store) return fail(store.error());
  std::vector<Edit> edits;
  NodeId id = (*store)->next_node_id();
  for (auto& node : imported->model.nodes) {
    node.id = id++;
    edits.emplace_back(AddNode{node});
  }
  RevisionInfo info;
  info.accepted_ns = wall_clock_ns();
  info.author = arguments.person.name;
  info.summary = "imported " + std::filesystem::path(arguments.model.file).filename().string();
  info.triangles_added = imported->model.triangle_count();
  auto model = (*store)->commit(edits, std::move(info));
  if (!model) return fail(model.error());
  if (arguments.json) {
    auto json = model_json(**model);
    json["imported"] = import_json(*imported);
    print_json(json);
    return {};
  }
  std::cout << import_text(arguments.model.file, *imported) << '\n';
  print_model(arguments, **model);
  return {};
}

using StoreAction = std::function<Status(const SceneArguments&, SceneStore&)>;

Status with_store(const SceneArguments& arguments, const StoreAction& action) {
  auto store = SceneStore::open(arguments.scene, false);
  if (!store) return fail(store.error());
  return action(arguments, **store);
}

Status scene_export(const SceneArguments& arguments, SceneStore& store) {
  auto model =
      arguments.revision ? store.model_at(*arguments.revision) : Result<std::shared_ptr<const Model>>{store.model()};
  if (!model) return fail(model.error());
  if (auto done = export_model(**model, arguments.file); !done) return done;
  if (arguments.json) {
    print_json(model_json(**model));
  } else {
    std::cout << fmt::format("{}: revision {}, {} triangles\n", arguments.file, (*model)->revision,
                             (*model)->triangle_count());
  }
  return {};
}

Status scene_info(const SceneArguments& arguments, SceneStore& store) {
  print_model(arguments, *store.model());
  return {};
}

Status scene_log(const SceneArguments& arguments, SceneStore& store) {
  return print_log(store, arguments.json, arguments.pictures);
}

Status scene_proposals(const SceneArguments& arguments, SceneStore& store) {
  for (const auto state : {ProposalState::open, ProposalState::accepted, ProposalState::rejected}) {
    if (name_of(state) == arguments.state) return print_proposals(store, arguments.json, state);
  }
  return print_proposals(store, arguments.json, std::nullopt);
}

Status print_result(const SceneArguments& arguments, const Result<std::shared_ptr<const Model>>& model) {
  if (!model) return fail(model.error());
  print_model(arguments, **model);
  return {};
}

Status scene_undo(const SceneArguments& arguments, SceneStore& store) {
  return print_result(arguments, store.undo(arguments.person.name));
}

Status scene_redo(const SceneArguments& arguments, SceneStore& store) {
  return print_result(arguments, store.redo(arguments.person.name));
}

Status scene_restore(const SceneArguments& arguments, SceneStore& store) {
  return print_result(arguments, store.restore(*arguments.revision, arguments.person.name));
}

CLI::App* add_one(CLI::App& scene, const char* name, const char* help, const std::shared_ptr<SceneArguments>& arguments,
                  Action& action, std::function<Status(const SceneArguments&)> run) {
  CLI::App* command = scene.add_subcommand(name, help);
  command->add_option("--scene", arguments->scene, "the scene file")->required();
  command->add_flag("--json", arguments->json, "result as JSON on stdout");
  command->callback([arguments, &action, run] { action = [arguments, run] { return run(*arguments); }; });
  return command;
}

std::function<Status(const SceneArguments&)> on_store(StoreAction action) {
  return [action](const SceneArguments& arguments) { return with_store(arguments, action); };
}

}  // namespace

void add_scene_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<SceneArguments>();
  CLI::App* scene =
      app.add_subcommand("scene", "the scene file: import, export, info, log, proposals, undo, redo, restore");
  scene->require_subcommand(1);
  CLI::App* importer =
      add_one(*scene, "import", "add a model file as a new revision; makes the scene file when it is not there",
              arguments, action, scene_import);
  arguments->model.add_to(*importer, "model");
  arguments->person.add_to(*importer);
  CLI::App* exporter = add_one(*scene, "export", "write the model", arguments, action, on_store(scene_export));
  exporter->add_option("file", arguments->file, "target: .glb, .ply or .obj")->required();
  exporter->add_option("--revision", arguments->revision, "the model as it was then; the present one if not given")
      ->check(counter());
  add_one(*scene, "info", "nodes and triangles", arguments, action, on_store(scene_info));
  CLI::App* log = add_one(*scene, "log", "the journal of revisions", arguments, action, on_store(scene_log));
  log->add_option("--pictures", arguments->pictures, "folder to write the snapshots' pictures to, as they are stored");
  CLI::App* proposals = add_one(*scene, "proposals", "what was proposed, and what became of it", arguments, action,
                                on_store(scene_proposals));
  proposals->add_option("--state", arguments->state, "which to list")
      ->check(CLI::IsMember({"all", "open", "accepted", "rejected"}))
      ->capture_default_str();
  CLI::App* undo = add_one(*scene, "undo", "go back by one revision", arguments, action, on_store(scene_undo));
  arguments->person.add_to(*undo);
  CLI::App* redo = add_one(*scene, "redo", "take an undo back", arguments, action, on_store(scene_redo));
  arguments->person.add_to(*redo);
  CLI::App* restore =
      add_one(*scene, "restore", "go back to any revision, as a new one that undo takes back; log has their numbers",
              arguments, action, on_store(scene_restore));
  restore->add_option("revision", arguments->revision, "the model as it was then; 0: empty")
      ->required()
      ->check(counter());
  arguments->person.add_to(*restore);
}

}  // namespace meshloop

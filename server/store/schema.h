#pragma once
#include <filesystem>

#include "common/base/result.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// Makes an empty scene file: complete under a temporary name first, so that under its own name stands a whole scene
/// or nothing. A scene that another process made meanwhile is left as it is.
[[nodiscard]] Status create_scene_file(const std::filesystem::path& file);

/// Refuses what is no file, or an empty one, which SQLite would take for an empty database. Makes a scene where there
/// is nothing, if `create` says so.
[[nodiscard]] Status make_sure_it_is_there(const std::filesystem::path& file, bool create);

/// A connection to a scene file, checked: the right program, a known schema, pages in order. A file that is refused
/// is unchanged. Where it or its folder may not be written, and without a log, it is read unlogged; FileIdentity then
/// has to say after each reading that nobody wrote meanwhile. The caller allows the connection to move its log into the
/// file once it has read the scene.
[[nodiscard]] Result<Database> open_scene_file(const std::filesystem::path& file);

/// Version 1 has no tables `snapshot` and `calibration`. Such a scene is read as it is.
[[nodiscard]] Result<bool> has_snapshots(Database& database);
/// Version 2 has no tables `proposal` and `accepted_proposal`; likewise.
[[nodiscard]] Result<bool> has_proposals(Database& database);
/// Versions 1 to 3 have no tables `texture` and `jpeg`. Such a scene is read as it is.
[[nodiscard]] Result<bool> has_textures(Database& database);
/// A scene of an earlier version becomes one of the present version. In a transaction, before anything else is written.
[[nodiscard]] Status bring_up_to_date(Database& database);

}  // namespace meshloop

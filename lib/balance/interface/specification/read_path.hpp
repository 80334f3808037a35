#pragma once
/// The paths of trajectories.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Reads `line`, `{circle: …}`, `{arc: …}`, `{waypoints: …}`, `{table: …}`, `{file: …}` or `{corridor: …}` into
/// trajectory.path and trajectory.corridor. Drive, poses, components and duration must have been read; tables replace
/// poses, components and duration.
void read_path(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

/// The centreline of a corridor; another path is its own.
SpecCursor corridor_centreline(const SpecCursor& path);
bool is_corridor(const SpecCursor& path);
/// Whether the path has its own poses and times.
bool is_table(const SpecCursor& path);
/// Whether the path is a circle, which can be read without its start.
bool is_circle(const SpecCursor& path);
/// Whether the path needs an end pose.
bool has_end_pose(const SpecCursor* path);

/// Reads `{along: line, width: 0.002}` into trajectory.corridor and its centreline into trajectory.path.
void read_corridor(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

/// Two kinds of path: `{table: [[t, …], …], columns: […]}` and `{file: motion.csv}`.
void read_table_path(const SpecCursor& table, const std::optional<SpecCursor>& columns, StudyBuilder& draft,
                     TrajectoryOf<Expression>& trajectory);
void read_file_path(const SpecCursor& file, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification

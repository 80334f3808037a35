#pragma once
/// The sections of a spec. Each reads its own key's value into the draft and collects what is wrong; each may rely on the
/// sections above it.

#include "balance/spec/draft.hpp"

namespace balance::specification {

void read_ground(const SpecCursor& section, StudyBuilder& draft);
void read_bodies(const SpecCursor& section, StudyBuilder& draft);
void read_joints(const SpecCursor& section, StudyBuilder& draft);
/// Every body must be reached from the ground through joints.
void check_connected(StudyBuilder& draft);
/// Bodies without mass, and points, must carry something. Once everything that they may carry has been read.
void check_massless_bodies(StudyBuilder& draft);
void read_couplings(const SpecCursor& section, StudyBuilder& draft);
void read_actuators(const SpecCursor& section, StudyBuilder& draft);
void read_tool(const SpecCursor& section, StudyBuilder& draft);
/// Sums of speeds that the equation of motion is wanted in: their start values.
std::vector<GeneralisedSpeed> read_speeds(const SpecCursor& section, StudyBuilder& draft);
/// Sums of speeds that are zero.
void read_constraints(const SpecCursor& section, StudyBuilder& draft);
void read_attachments(const SpecCursor& section, StudyBuilder& draft, AttachmentKind kind);
void read_discs(const SpecCursor& section, StudyBuilder& draft);
void read_loads(const SpecCursor& section, StudyBuilder& draft);
void read_springs(const SpecCursor& section, StudyBuilder& draft);
void read_friction(const SpecCursor& section, StudyBuilder& draft);
/// `motion` and `trajectories` together: a trajectory takes from `motion` what it does not say itself.
void read_trajectories(const SpecCursor* motion, const SpecCursor* trajectories, StudyBuilder& draft);
/// @param root, overrides of the whole spec, for what a controller believes of the mechanism. Null section: the built-in ones alone.
void read_controllers(const SpecCursor* section, const YamlNode& root, const SpecParameters::Overrides& overrides,
                      StudyBuilder& draft);
void read_design(const SpecCursor& section, StudyBuilder& draft);

}  // namespace balance::specification

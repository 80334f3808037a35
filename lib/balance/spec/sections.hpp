#pragma once
/// The sections of a spec. Each reads its own key's value into the draft and collects what is wrong; each may rely on the
/// sections above it.

#include "balance/spec/draft.hpp"

namespace balance::read {

void read_ground(const Cursor& section, Draft& draft);
void read_bodies(const Cursor& section, Draft& draft);
void read_joints(const Cursor& section, Draft& draft);
/// Every body must be reached from the ground through joints.
void check_connected(Draft& draft);
/// Bodies without mass, and points, must carry something. Once everything that they may carry has been read.
void check_light_bodies(Draft& draft);
void read_couplings(const Cursor& section, Draft& draft);
void read_actuators(const Cursor& section, Draft& draft);
void read_tool(const Cursor& section, Draft& draft);
/// Sums of speeds that the equation of motion is wanted in: their start values.
std::vector<Speed> read_speeds(const Cursor& section, Draft& draft);
/// Sums of speeds that are zero.
void read_constraints(const Cursor& section, Draft& draft);
void read_attachments(const Cursor& section, Draft& draft, AttachmentKind kind);
void read_discs(const Cursor& section, Draft& draft);
void read_loads(const Cursor& section, Draft& draft);
void read_springs(const Cursor& section, Draft& draft);
void read_friction(const Cursor& section, Draft& draft);
/// `motion` and `trajectories` together: a trajectory takes from `motion` what it does not say itself.
void read_trajectories(const Cursor* motion, const Cursor* trajectories, Draft& draft);
/// @param root, overrides of the whole spec, for what a controller believes of the mechanism. Null section: the built-in ones alone.
void read_controllers(const Cursor* section, const Node& root, const Parameters::Overrides& overrides, Draft& draft);
void read_design(const Cursor& section, Draft& draft);

}  // namespace balance::read

#pragma once
/// Temporary payloads, which are picked up and set down during the motion: `from`, `until`.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>

namespace balance::specification {

/// A time of a trajectory [s]: a number, or an expression that no free number, load case or tolerance changes.
double read_fixed_time(const SpecCursor& at, StudyBuilder& draft);

/// Keys of a payload for when it is present.
struct PresenceKeys {
  std::optional<SpecCursor> from, until;

  bool given() const { return from || until; }
};

/// The keys `from` and `until` of a payload. For a counterweight only those that are given, in order to reject them.
std::vector<Field> presence_fields(const SpecCursor& at, AttachmentKind kind, PresenceKeys& keys);

/// Stores the times in the attachment, and their place in the study.
void read_presence(const PresenceKeys& keys, StudyBuilder& draft, model::AttachmentOf<Expression>& attachment);

/// Fails if there are temporary payloads, which are not allowed here. @param expected what is expected instead
void require_permanent_payloads(const SpecCursor& at, const std::string& expected, const StudyBuilder& draft);

/// Whether free numbers, load cases or tolerances change the number.
bool is_variable_number(const Expression& number, const StudyBuilder& draft);

/// Keys of a trajectory that may conflict with temporary payloads.
struct MotionKeys {
  const SpecCursor& at;
  const std::optional<SpecCursor>&drive, &law, &limits;
  SpecCursor from, to;
};

/// Fails for anything that depends on the moving masses: it would jump with them, or be found for masses
/// that are not always present.
void check_temporary_payloads(const MotionKeys& keys, const StudyBuilder& draft,
                              const TrajectoryOf<Expression>& trajectory);

/// Once all trajectories are known, checks that every payload is present in one of them.
void check_presence(StudyBuilder& draft);

}  // namespace balance::specification

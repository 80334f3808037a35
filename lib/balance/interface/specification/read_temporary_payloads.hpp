#pragma once
/// Payloads that are taken up and set down on the way: `from`, `until`.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>

namespace balance::specification {

/// Where a payload says when it is there.
struct PresenceKeys {
  std::optional<SpecCursor> from, until;

  bool given() const { return from || until; }
};

/// The keys `from` and `until` of a payload. Of a counterweight none but those that are there, to be refused.
std::vector<Field> presence_fields(const SpecCursor& at, AttachmentKind kind, PresenceKeys& text);

/// Into the attachment, and where it is said into the study.
void read_presence(const PresenceKeys& text, StudyBuilder& draft, AttachmentOf<Expression>& attachment);

/// Fails if something comes or goes on the way and may not where this stands. @param expected what is expected there instead
void require_permanent_payloads(const SpecCursor& at, const std::string& expected, const StudyBuilder& draft);

/// Whether free numbers, load cases or tolerances change it.
bool is_variable_number(const Expression& number, const StudyBuilder& draft);

/// Where a trajectory says what payloads that come and go may not suit.
struct MotionKeys {
  const SpecCursor& at;
  const std::optional<SpecCursor>&drive, &law, &limits;
  SpecCursor from, to;
};

/// What depends on the masses that move would jump with them, or be found for masses that are not always there.
void check_temporary_payloads(const MotionKeys& text, const StudyBuilder& draft,
                              const TrajectoryOf<Expression>& trajectory);

/// Once all trajectories are known: a payload must be there in one of them.
void check_presence(StudyBuilder& draft);

}  // namespace balance::specification

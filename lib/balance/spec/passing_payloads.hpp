#pragma once
/// Payloads that are taken up and set down on the way: `from`, `until`. Private to the readers.

#include "balance/spec/draft.hpp"

#include <optional>

namespace balance::read {

/// Where a payload says when it is there.
struct PresenceText {
  std::optional<Cursor> from, until;

  bool given() const { return from || until; }
};

/// The keys `from` and `until` of a payload. Of a counterweight none but those that are there, to be refused.
std::vector<Field> presence_fields(const Cursor& at, AttachmentKind kind, PresenceText& text);

/// Into the attachment, and where it is said into the study.
void read_presence(const PresenceText& text, Draft& draft, AttachmentOf<Expression>& attachment);

/// Fails if something comes or goes on the way and may not where this stands. @param expected what is expected there instead
void expect_lasting_payloads(const Cursor& at, const std::string& expected, const Draft& draft);

/// Whether free numbers, load cases or tolerances change it.
bool is_moving(const Expression& number, const Draft& draft);

/// Where a trajectory says what payloads that come and go may not suit.
struct MotionText {
  const Cursor& at;
  const std::optional<Cursor>&drive, &law, &limits;
  Cursor from, to;
};

/// What depends on the masses that move would jump with them, or be found for masses that are not always there.
void check_passing(const MotionText& text, const Draft& draft, const TrajectoryOf<Expression>& trajectory);

/// Once all trajectories are known: a payload must be there in one of them.
void check_presence(Draft& draft);

}  // namespace balance::read

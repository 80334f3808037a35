// How efforts are distributed over more actuators than degrees of freedom.

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/study_builder.hpp"

#include <fmt/format.h>

#include <functional>
#include <vector>

namespace balance::specification {

namespace {

using Share = model::EffortShareOf<Expression>;

/// Reads one entry for an actuator whose efforts have this dimension.
using ReadEntry = std::function<void(const SpecCursor& at, Dimension effort, Share& share)>;

class TorqueDistributionReader {
 public:
  explicit TorqueDistributionReader(StudyBuilder& draft) : draft_(draft) {}

  void read(const SpecCursor& section) {
    model::TorqueDistributionOf<Expression> distribution;
    const std::vector<CoordinateId>& actuators = draft_.mechanism().actuators;
    const bool is_uncertain =
        actuators.empty() ? draft_.problems.is_uncertain("actuators") : draft_.problems.is_invalid("actuators");
    if (is_uncertain) throw CascadingError();
    if (actuators.empty())
      section.fail({.expected = "'actuators', more than there are degrees of freedom", .found = "a spec without them"});
    distribution.shares.resize(actuators.size());
    const auto entries = [&](const char* what, ReadEntry read_entry) {
      return [this, what, &distribution, read_entry = std::move(read_entry)](const SpecCursor& c) {
        read_entries(c, what, read_entry, distribution.shares);
      };
    };
    const bool is_read = read_fields(
        section, "a torque distribution {method, weights, limits, preload}",
        {{"method", Presence::optional,
          [&](const SpecCursor& c) {
            distribution.method = static_cast<model::DistributionMethod>(c.read_choice(
                "a method",
                {name_of(model::DistributionMethod::min_norm), name_of(model::DistributionMethod::min_peak)}));
          }},
         {"weights", Presence::optional,
          entries("a weight",
                  [this](const SpecCursor& c, Dimension, Share& share) {
                    share.weight = read_number(c, draft_, dimension::dimensionless, SignConstraint::positive);
                  })},
         {"limits", Presence::optional,
          entries("a limit, or [lowest, highest]",
                  [this](const SpecCursor& c, Dimension effort, Share& share) { read_limit(c, effort, share); })},
         {"preload", Presence::optional,
          entries("a preload", [this](const SpecCursor& c, Dimension effort, Share& share) {
            share.preload = read_number(c, draft_, effort);
            if (share.preload->value() == 0) c.fail_expected("a number other than 0, whose sign the effort keeps");
          })}});
    if (!is_read) return;
    check_bounds(section, distribution.shares);
    draft_.mechanism().torque_distribution = std::move(distribution);
  }

 private:
  std::string name_of_actuator(std::size_t a) const {
    const auto c = static_cast<std::size_t>(draft_.mechanism().actuators[a]);
    return draft_.mechanism().coordinates[c].name;
  }

  Dimension effort_of(std::size_t a) const {
    const auto c = static_cast<std::size_t>(draft_.mechanism().actuators[a]);
    return draft_.mechanism().coordinates[c].kind == CoordinateKind::angle ? dimension::moment : dimension::force;
  }

  /// One entry for all actuators, a list in their order, or a mapping with entries for some of them.
  void read_entries(const SpecCursor& at, const std::string& what, const ReadEntry& read_entry,
                    std::vector<Share>& shares) const {
    std::vector<std::string> names;
    for (std::size_t a = 0; a < shares.size(); ++a) names.push_back(name_of_actuator(a));
    const std::string expected =
        fmt::format("{}, a list with one for each of the {} actuators, or a mapping of actuators", what, shares.size());
    read_entry_per_name(at, names, Presence::optional, expected, expected,
                        [&](const SpecCursor& c, std::size_t a) { read_entry(c, effort_of(a), shares[a]); });
  }

  void read_limit(const SpecCursor& at, Dimension effort, Share& share) const {
    if (!at.is_list()) {
      share.upper = read_number(at, draft_, effort, SignConstraint::not_negative);
      share.lower = share.upper->value() == 0 ? *share.upper : -*share.upper;  // no bound is -0
      return;
    }
    const std::vector<SpecCursor> bounds = at.items("[lowest, highest]", 2);
    share.lower = read_number(bounds[0], draft_, effort);
    share.upper = read_number(bounds[1], draft_, effort);
    if (share.lower->value() > share.upper->value()) at.fail_expected("[lowest, highest], the lower first");
  }

  /// Limits and preload must leave an effort.
  void check_bounds(const SpecCursor& section, const std::vector<Share>& shares) const {
    for (std::size_t a = 0; a < shares.size(); ++a) {
      const Share& share = shares[a];
      if (!share.preload || !share.upper) continue;
      const double preload = share.preload->value();
      if (preload > 0 ? preload > share.upper->value() : preload < share.lower->value())
        section.fail(
            {.expected = fmt::format("a preload of {} within its limits", quote_for_message(name_of_actuator(a))),
             .found = "one beyond them"});
    }
  }

  StudyBuilder& draft_;
};

}  // namespace

void read_torque_distribution(const SpecCursor& section, StudyBuilder& draft) {
  TorqueDistributionReader(draft).read(section);
}

}  // namespace balance::specification

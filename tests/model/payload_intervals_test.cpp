// When payloads are there that come and go.

#include "balance/mechanics/model/payload_intervals.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

using namespace balance;
using namespace balance::model;

namespace {

Mechanism carrying_for(std::initializer_list<std::pair<double, double>> times) {
  Mechanism mechanism;
  mechanism.bodies.resize(2);
  for (const auto& [from, until] : times) {
    Attachment one;
    one.kind = AttachmentKind::payload;
    one.body = 1;
    one.mass = 2;
    one.from = from, one.until = until;
    mechanism.attachments.push_back(one);
  }
  return mechanism;
}

constexpr double always = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("payloads cut a motion into stretches at the times strictly inside it, each once") {
  const Mechanism mechanism =
      carrying_for({{0.2, 0.7}, {0.7, 3}, {-1, 0.2 + 1e-14}, {-always, always}, {0, 2}, {-always, 2 - 1e-13}});
  const PayloadIntervals stretches(mechanism, 2);
  REQUIRE(stretches.switch_times() == std::vector<double>{0.2, 0.7});
  const std::vector<std::vector<bool>> there{{false, true, false}, {false, false, true}, {true, false, false},
                                             {true, true, true},   {true, true, true},   {true, true, true}};
  for (std::size_t a = 0; a < there.size(); ++a)
    for (int k = 0; k < stretches.count(); ++k)
      CHECK(stretches.is_attached(a, k) == there[a][static_cast<std::size_t>(k)]);
}

TEST_CASE("a switch belongs to the stretch that it begins, by whatever round-off it is missed") {
  const PayloadIntervals stretches(carrying_for({{0.2, 0.7}}), 1);
  CHECK(stretches.index_at(0) == 0);
  CHECK(stretches.index_at(0.2 - 1e-9) == 0);
  CHECK(stretches.index_at(0.2 - 1e-13) == 1);
  CHECK(stretches.index_at(0.2) == 1);
  CHECK(stretches.index_at(0.7) == 2);
  CHECK(stretches.index_at(1) == 2);
}

TEST_CASE("a mechanism within a stretch has all its elements, and no mass where they are not") {
  const Mechanism mechanism = carrying_for({{0.2, 0.7}, {-always, always}});
  const PayloadIntervals stretches(mechanism, 1);
  for (int k = 0; k < 3; ++k) {
    const Mechanism there = mechanism_in_interval(mechanism, stretches, k);
    REQUIRE(there.attachments.size() == 2);
    CHECK_FALSE(has_temporary_payloads(there));
    CHECK(there.attachments[0].mass == (k == 1 ? 2 : 0));
    CHECK(there.attachments[1].mass == 2);
  }
  CHECK(mechanism_at_time(mechanism, 0.2).attachments[0].mass == 2);
  CHECK(mechanism_at_time(mechanism, 0.7).attachments[0].mass == 0);
}

TEST_CASE("what never comes nor goes is one stretch") {
  CHECK(PayloadIntervals().is_attached(5, 0));
  CHECK(PayloadIntervals(carrying_for({{-always, always}}), 1).count() == 1);
}

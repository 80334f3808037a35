// When payloads are there that come and go.

#include "balance/model/payload_stretches.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

using namespace balance;

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
  const PayloadStretches stretches(mechanism, 2);
  REQUIRE(stretches.switches() == std::vector<double>{0.2, 0.7});
  const std::vector<std::vector<bool>> there{{false, true, false}, {false, false, true}, {true, false, false},
                                             {true, true, true},   {true, true, true},   {true, true, true}};
  for (std::size_t a = 0; a < there.size(); ++a)
    for (int k = 0; k < stretches.count(); ++k)
      CHECK(stretches.is_there(a, k) == there[a][static_cast<std::size_t>(k)]);
}

TEST_CASE("a switch belongs to the stretch that it begins, by whatever round-off it is missed") {
  const PayloadStretches stretches(carrying_for({{0.2, 0.7}}), 1);
  CHECK(stretches.from(0) == 0);
  CHECK(stretches.from(0.2 - 1e-9) == 0);
  CHECK(stretches.from(0.2 - 1e-13) == 1);
  CHECK(stretches.from(0.2) == 1);
  CHECK(stretches.from(0.7) == 2);
  CHECK(stretches.from(1) == 2);
}

TEST_CASE("a mechanism within a stretch has all its elements, and no mass where they are not") {
  const Mechanism mechanism = carrying_for({{0.2, 0.7}, {-always, always}});
  const PayloadStretches stretches(mechanism, 1);
  for (int k = 0; k < 3; ++k) {
    const Mechanism there = within(mechanism, stretches, k);
    REQUIRE(there.attachments.size() == 2);
    CHECK_FALSE(has_passing_payloads(there));
    CHECK(there.attachments[0].mass == (k == 1 ? 2 : 0));
    CHECK(there.attachments[1].mass == 2);
  }
  CHECK(at_time(mechanism, 0.2).attachments[0].mass == 2);
  CHECK(at_time(mechanism, 0.7).attachments[0].mass == 0);
}

TEST_CASE("what never comes nor goes is one stretch") {
  CHECK(PayloadStretches().is_there(5, 0));
  CHECK(PayloadStretches(carrying_for({{-always, always}}), 1).count() == 1);
}

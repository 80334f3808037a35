#include "schedules.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace table_test {

using namespace balance;
using namespace balance::trajectory;

namespace {

constexpr double pi = std::numbers::pi;

/// sin and cos of 3t on uneven times from 2 to 4.
TablePath smooth_table(int intervals) {
  TablePath table;
  for (int i = 0; i <= intervals; ++i) {
    const double part = static_cast<double>(i) / intervals;
    const double time = 2 + 2 * part + 0.1 * std::sin(pi * part);
    table.time.push_back(time);
    table.values.push_back({std::sin(3 * time), std::cos(3 * time)});
  }
  return table;
}

PrescribedMotion::Request request_of(TablePath table, bool turns = false) {
  PrescribedMotion::Request request;
  request.law = {MotionLawKind::bang_bang};  // neither this nor the duration counts
  request.path = std::move(table);
  request.duration = 77;
  request.has_rotation = turns;
  return request;
}

struct Errors {
  double value = 0, rate = 0, acceleration = 0;
};

Errors errors_of(int intervals) {
  const PrescribedMotion schedule(request_of(smooth_table(intervals)));
  Errors worst;
  for (int i = 0; i <= 1999; ++i) {
    const double time = 2.0 * i / 1999, phase = 3 * (2 + time);
    const DriveSample sample = sample_at(schedule, time);
    const double sine = std::sin(phase), cosine = std::cos(phase);
    worst.value = std::max(worst.value, (sample.value - values({sine, cosine})).norm());
    worst.rate = std::max(worst.rate, (sample.rate - values({3 * cosine, -3 * sine})).norm());
    worst.acceleration = std::max(worst.acceleration, (sample.acceleration - values({-9 * sine, -9 * cosine})).norm());
  }
  return worst;
}

/// A rotation that changes its axis, as a rotation vector.
Vector3 swinging(double time) { return {std::sin(time), 0.8 * std::cos(2 * time), time}; }

TablePath swinging_table(int intervals) {
  TablePath table;
  for (int i = 0; i <= intervals; ++i) {
    const double time = 1.5 * i / intervals;
    const Vector3 vector = swinging(time);
    table.time.push_back(time);
    table.values.push_back({time * time, vector.x(), vector.y(), vector.z()});
  }
  return table;
}

}  // namespace

TEST_CASE("a table brings its own duration and size, and no jumps") {
  const PrescribedMotion schedule(request_of(smooth_table(10)));
  CHECK(schedule.duration() == doctest::Approx(2));
  CHECK(schedule.component_count() == 2);
  CHECK(schedule.jump_times().empty());
}

TEST_CASE("a table's values are met at its times, counted from the first") {
  const TablePath table = smooth_table(10);
  const PrescribedMotion schedule(request_of(table));
  for (std::size_t i = 0; i < table.time.size(); ++i) {
    const DriveSample sample = sample_at(schedule, table.time[i] - table.time.front());
    CHECK((sample.value - values({table.values[i][0], table.values[i][1]})).norm() < 1e-14);  // round-off of the time
  }
}

TEST_CASE("a table interpolates a smooth motion with order 4, velocities with 3, accelerations with 2") {
  const Errors coarse = errors_of(64), fine = errors_of(128);
  // half an order below the theory: the next term of the expansion still shows at these sizes
  CHECK(std::log2(coarse.value / fine.value) > 3.5);
  CHECK(std::log2(coarse.rate / fine.rate) > 2.5);
  CHECK(std::log2(coarse.acceleration / fine.acceleration) > 1.5);
  // and is as near as a cubic can be: 5/384 of the fourth power of the step times the fourth derivative, 81, at the middle;
  // the ends are a few times worse
  const double step = 2.0 / 128 * (1 + 0.05 * pi);
  CHECK(fine.value < 5 * 5.0 / 384 * std::pow(step, 4) * 81);
}

TEST_CASE("a table's derivatives meet finite differences, rotations included") {
  check_derivatives(PrescribedMotion(request_of(smooth_table(20))), 1e6);  // across a knot h times the jump of the jerk
  check_derivatives(PrescribedMotion(request_of(swinging_table(20), true)), 1e6);
}

TEST_CASE("a table of rotation vectors follows the rotation with order 4") {
  const auto error = [](int intervals) {
    const PrescribedMotion schedule(request_of(swinging_table(intervals), true));
    CHECK(schedule.component_count() == 1);
    double worst = 0;
    for (int i = 0; i <= 997; ++i) {
      const double time = 1.5 * i / 997;
      worst =
          std::max(worst, (sample_at(schedule, time).rotation - rotation_from_rotation_vector(swinging(time))).norm());
    }
    return worst;
  };
  CHECK(std::log2(error(40) / error(80)) > 3.5);
}

TEST_CASE("rotation vectors that jump from one side of half a turn to the other make no detour") {
  // a steady spin about z, each rotation written by its shortest vector
  TablePath table;
  for (int i = 0; i <= 12; ++i) {
    const Vector3 vector = rotation_vector_of(rotation_about(Vector3::UnitZ(), 0.7 * i + 0.1));
    table.time.push_back(i);
    table.values.push_back({vector.x(), vector.y(), vector.z()});
  }
  const PrescribedMotion schedule(request_of(table, true));
  for (int i = 0; i <= 60; ++i) {
    const DriveSample sample = sample_at(schedule, 0.2 * i);
    CHECK((sample.angular_velocity - Vector3(0, 0, 0.7)).norm() < 1e-12);  // round-off
    CHECK((sample.rotation - rotation_about(Vector3::UnitZ(), 0.14 * i + 0.1)).norm() < 1e-12);
  }
}

TEST_CASE("rotation vectors that run on beyond a turn are taken as they stand") {
  TablePath table;
  for (int i = 0; i <= 12; ++i) {
    table.time.push_back(i);
    table.values.push_back({0, 0, i * pi / 4});  // passes 2π exactly
  }
  const PrescribedMotion schedule(request_of(table, true));
  for (int i = 0; i <= 60; ++i) {
    CHECK((sample_at(schedule, 0.2 * i).angular_velocity - Vector3(0, 0, pi / 4)).norm() < 1e-12);  // round-off
  }
}

TEST_CASE("tables that state no motion are refused with their reason") {
  const auto changed = [](auto change) {
    TablePath table = smooth_table(5);
    change(table);
    return refusal(request_of(table));
  };
  CHECK(changed([](TablePath&) {}).empty());
  CHECK(says(changed([](TablePath& t) { t.time.resize(3), t.values.resize(3); }), "at least 4 rows"));
  CHECK(says(changed([](TablePath& t) { t.values.pop_back(); }), "6 times but 5 rows"));
  CHECK(says(changed([](TablePath& t) { t.time[3] = t.time[2]; }), "row 4"));
  CHECK(says(changed([](TablePath& t) { t.time[0] = std::nan(""); }), "row 1"));
  CHECK(says(changed([](TablePath& t) { t.time[5] = INFINITY; }), "must increase"));
  CHECK(says(changed([](TablePath& t) { t.values[2].push_back(1); }), "row 3"));
  CHECK(says(changed([](TablePath& t) { t.values[2][1] = std::nan(""); }), "row 3"));
  PrescribedMotion::Request request = request_of(smooth_table(5));
  request.from.value = values({1, 2, 3});
  CHECK(says(refusal(request), "2 values per row, but the drive has 3"));
  CHECK(says(refusal(request_of(smooth_table(5), true)), "2 values per row"));  // no room for a rotation vector
}

}  // namespace table_test

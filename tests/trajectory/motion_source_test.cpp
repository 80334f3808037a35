/// How a motion is visited, with a source that moves nothing: its one coordinate is the prescribed value.

#include "schedules.hpp"

#include "balance/mechanics/trajectory/time_grid.hpp"

#include <limits>
#include <vector>

using namespace balance;
using namespace balance::trajectory;

namespace {

/// Up at constant acceleration, down at constant acceleration, with a payload that changes in between.
PrescribedMotion bang_bang() {
  PrescribedMotion::Request request;
  request.law.kind = MotionLawKind::bang_bang;
  request.duration = 2;
  request.from.value = values({1});
  request.to.value = values({4});
  request.switch_times = {0.3};
  return PrescribedMotion(request);
}

class Follower final : public MotionSource {
 public:
  explicit Follower(double last = std::numeric_limits<double>::infinity()) : last_(last) {
    outcome_.status = MotionStatus::done;
    sample_.position = sample_.velocity = sample_.acceleration = values({0});
  }

  const MotionOutcome& outcome() const override { return outcome_; }
  const PrescribedMotion& prescribed_motion() const override { return motion_; }
  bool begin() override {
    updates_before_begin = payload_updates.size();
    return true;
  }
  bool advance(double time) override {
    CHECK(time > sample_.time);
    for (const double jump : motion_.jump_times()) CHECK_FALSE((sample_.time < jump && jump < time));
    if (time > last_) {
      outcome_ = {MotionStatus::assembly_jump, last_, "too far", {}};
      return false;
    }
    sample_.time = time;
    side_ = Side::after;
    return true;
  }
  void update_accelerations(Side side) override { side_ = side; }
  bool update_payloads() override {
    CHECK(side_ == Side::after);
    payload_updates.push_back(sample_.time);
    return false;
  }
  double time() const override { return sample_.time; }
  bool evaluate() override {
    const DriveSample sample = sample_at(motion_, sample_.time, side_);
    sample_.position = sample.value;
    sample_.velocity = sample.rate;
    sample_.acceleration = sample.acceleration;
    return true;
  }
  const Sample& sample() const override { return sample_; }
  double point_speed(BodyId, const Vector3&) const override { return 0; }
  double angular_speed(BodyId) const override { return 0; }

  std::vector<double> payload_updates;
  std::size_t updates_before_begin = 0;

 private:
  PrescribedMotion motion_ = bang_bang();
  double last_;
  Side side_ = Side::after;
  Sample sample_;
  MotionOutcome outcome_;
};

Mechanism one_coordinate() {
  Mechanism mechanism;
  mechanism.coordinates.resize(1);
  return mechanism;
}

}  // namespace

TEST_CASE("a time grid meets every sample in order and both sides of every jump, with payloads changed in between") {
  Follower source;
  double last = -1, before = 0, after = 0;
  long samples = 0;
  CHECK(visit_time_grid(source, 500, [&](const TimeGridPoint& point) {
    CHECK(source.time() >= last);
    last = source.time();
    CHECK(source.evaluate());
    if (point.kind == TimeGridPoint::Kind::sample) CHECK(point.index == samples++);
    if (point.kind == TimeGridPoint::Kind::before_jump && point.index == 1) before = source.sample().acceleration[0];
    if (point.kind == TimeGridPoint::Kind::after_jump && point.index == 1) after = source.sample().acceleration[0];
    return true;
  }));
  CHECK(samples == 500);
  CHECK(last == 2);
  CHECK(source.updates_before_begin == 1);
  CHECK(source.payload_updates == std::vector<double>{0, 0.3, 1});
  CHECK(before == doctest::Approx(3).epsilon(1e-12));  // 4 (to - from) / duration^2
  CHECK(after == doctest::Approx(-3).epsilon(1e-12));
}

TEST_CASE("a time grid ends where its source or its visitor does") {
  Follower failing(0.7);
  double last = 0;
  CHECK_FALSE(visit_time_grid(failing, 500, [&](const TimeGridPoint&) {
    last = failing.time();
    return true;
  }));
  CHECK(last <= 0.7);
  CHECK(last > 0.69);
  CHECK(failing.outcome().status == MotionStatus::assembly_jump);

  Follower stopped;
  CHECK_FALSE(visit_time_grid(stopped, 500, [&](const TimeGridPoint&) { return stopped.time() < 0.5; }));
  CHECK(stopped.time() >= 0.5);
  CHECK(stopped.time() < 0.51);
}

TEST_CASE("a sampled motion has the prescribed values at its times, and rests in its last pose afterwards") {
  Follower source;
  const std::vector<double> times{0, 0.01, 0.9, 1, 1.7, 2, 2.5, 7};
  const MotionTable table = sample_motion(one_coordinate(), source, times);
  CHECK(table.outcome.status == MotionStatus::done);
  CHECK(table.duration == 2);
  CHECK(table.rows == 8);
  for (Eigen::Index k = 0; k < table.rows; ++k) {
    const double time = times[static_cast<std::size_t>(k)];
    CAPTURE(time);
    const DriveSample sample = sample_at(source.prescribed_motion(), std::min(time, 2.0));  // 1 s: after the jump
    CHECK(table.position(k, 0) == sample.value[0]);
    CHECK(table.velocity(k, 0) == (time > 2 ? 0 : sample.rate[0]));
    CHECK(table.acceleration(k, 0) == (time > 2 ? 0 : sample.acceleration[0]));
  }
}

TEST_CASE("a sampled motion that ends early has the rows before its end and says why") {
  Follower source(1.2);
  const MotionTable table = sample_motion(one_coordinate(), source, {0, 0.5, 1.1, 1.3, 2});
  CHECK(table.outcome.status == MotionStatus::assembly_jump);
  CHECK(table.rows == 3);
  CHECK(table.position(2, 0) == sample_at(source.prescribed_motion(), 1.1).value[0]);
}

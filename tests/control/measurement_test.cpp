#include "arms.hpp"

#include "balance/motion/control/sensor.hpp"

using namespace arms;

TEST_CASE("the sensor's noise has the stated deviation and no mean, its positions are whole steps") {
  study::Measurement m;
  m.position_noise = all(1, 0.01);
  m.velocity_noise = all(1, 0.5);
  control::Sensor sensor(m, 1e-3);
  const int count = 40'000;
  double sum[2] = {0, 0}, squares[2] = {0, 0}, product = 0;
  for (int i = 0; i < count; ++i) {
    sensor.read(all(1, 1), all(1, 2), all(1, 0));
    const double x[2] = {(sensor.position()[0] - 1) / 0.01, (sensor.velocity()[0] - 2) / 0.5};
    for (int k = 0; k < 2; ++k) sum[k] += x[k], squares[k] += x[k] * x[k];
    product += x[0] * x[1];
  }
  for (int k = 0; k < 2; ++k) {
    CHECK(std::abs(sum[k] / count) < 5 / std::sqrt(count));  // five standard deviations of the estimate
    CHECK(std::abs(squares[k] / count - 1) < 5 * std::sqrt(2.0 / count));
  }
  CHECK(std::abs(product / count) < 5 / std::sqrt(count));
  study::Measurement steps;
  steps.position_step = all(1, 0.1);
  control::Sensor encoder(steps, 1e-3);
  encoder.read(all(1, 0.349), all(1, 1), all(1, 0));
  CHECK(encoder.position()[0] == doctest::Approx(0.3));
  CHECK(encoder.velocity()[0] == 1);
}

TEST_CASE("differences of quantised positions are whole steps per period, after the desired rate at the first sample") {
  study::Measurement m;
  m.position_step = all(1, 0.01);
  m.velocity = study::VelocitySource::difference;
  control::Sensor sensor(m, 0.002);
  sensor.read(all(1, 0.1), all(1, 9), all(1, 3));
  CHECK(sensor.velocity()[0] == 3);
  sensor.read(all(1, 0.124), all(1, 9), all(1, 3));
  CHECK(sensor.velocity()[0] == doctest::Approx(10));
}

TEST_CASE("the same seed gives the same run to the last bit, another one another") {
  const Study study = five_bar();
  Controller c = controller(study::ControllerType::computed_torque, 500);
  c.measurement.position_noise = all(2, 1e-4);
  c.measurement.position_step = all(2, 1e-5);
  c.measurement.velocity = study::VelocitySource::difference;
  const RunResult a = run(study, "cycloid", c, 51), b = run(study, "cycloid", c, 51);
  CHECK(a.joint_position == b.joint_position);
  CHECK(a.torque == b.torque);
  c.measurement.seed = 2;
  CHECK(run(study, "cycloid", c, 51).torque != a.torque);
}

TEST_CASE("a torque limit is honoured on both sides of every change, and saturation is the share of time at it") {
  const Study study = arm();
  Controller c = controller(study::ControllerType::computed_torque, 1000);
  c.initial_error.joints = {{0, -0.3}};
  const double most = 20;  // it holds the arm (11.8 N m), but is far from what the error asks for
  REQUIRE(metric(run(study, "cycloid", c), "torque").peak > 10 * most);
  c.torque_limit = all(1, most);
  const RunResult r = run(study, "cycloid", c, 1001, 1);
  CHECK(metric(r, "torque").peak == doctest::Approx(most));
  long cut = 0;
  for (long k = 0; k < r.time.size(); ++k) {
    CHECK(std::abs(r.torque(k, 0)) <= most);
    CHECK((r.saturation(k, 0) == 1) == (std::abs(r.torque(k, 0)) == most));
    cut += r.saturation(k, 0) == 1;
  }
  CHECK(cut > 10);
  // one sample of the result per sample of the controller
  CHECK(metric(r, "saturation[J]").mean ==
        doctest::Approx(static_cast<double>(cut) / static_cast<double>(r.time.size() - 1)).epsilon(1e-6));
  CHECK(std::abs(r.tracking_error(r.time.size() - 1, 0)) < 1e-3);
}

TEST_CASE("metrics do not depend on how often the result is sampled: every change of the torque counts") {
  const Study study = arm();
  Controller c = controller(study::ControllerType::sliding_mode, 500);
  c.initial_error.joints = {{0, 0.05}};
  const RunResult fine = run(study, "cycloid", c, 2001), rare = run(study, "cycloid", c, 11);
  CHECK(metric(rare, "torque").peak == doctest::Approx(metric(fine, "torque").peak).epsilon(1e-6));
  CHECK(metric(rare, "torque").rms == doctest::Approx(metric(fine, "torque").rms).epsilon(1e-6));
  CHECK(metric(rare, "torque_variation").peak == doctest::Approx(metric(fine, "torque_variation").peak).epsilon(1e-6));
  CHECK(metric(rare, "tracking_error").rms == doctest::Approx(metric(fine, "tracking_error").rms).epsilon(1e-4));
}

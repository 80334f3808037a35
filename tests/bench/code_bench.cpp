/// The program that `balance equations --code c` prints of a six-joint arm like the UR5, compiled, beside the engine's efforts of
/// the same states; and how long it takes to derive. The ratio of the first two is what counts.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/program_code.hpp"

#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

namespace balance {
namespace {

constexpr int joints = 6;

/// Lengths and twists of the UR5's Denavit–Hartenberg table; masses of its data sheet, placed by halves of lengths.
Mechanism six_joint_arm() {
  constexpr double half = std::numbers::pi / 2;
  const double a[joints] = {0, -0.425, -0.39225, 0, 0, 0}, d[joints] = {0.089159, 0, 0, 0.10915, 0.09465, 0.0823};
  const double twist[joints] = {half, 0, 0, half, -half, 0}, mass[joints] = {3.7, 8.393, 2.33, 1.219, 1.219, 0.1879};
  Mechanism m;
  m.space = SpaceKind::spatial;
  m.gravity = {0, 0, -9.81};
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  Vector3 end = Vector3::Zero();
  Matrix3 turned = Matrix3::Identity();
  for (int j = 0; j < joints; ++j) {
    Body body;
    body.name = "link" + std::to_string(j + 1);
    body.mass = mass[j], body.com = {a[j] / 2, 0.01, d[j] / 2};
    body.inertia = Vector3(0.01, 0.02, 0.015).asDiagonal();
    m.bodies.push_back(body);
    Joint joint;
    joint.name = "J" + std::to_string(j + 1);
    joint.first = j, joint.second = j + 1;
    joint.point_first = end, joint.rotation = turned, joint.axis = turned.col(2);
    m.joints.push_back(joint);
    end = {a[j], 0, d[j]};
    // right angles to their last digit, as a spec has them
    const double c = std::round(std::cos(twist[j])), s = std::round(std::sin(twist[j]));
    turned << 1, 0, 0, 0, c, -s, 0, s, c;
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  for (int j = 0; j < joints; ++j) m.actuators.push_back(j);
  return m;
}

constexpr Eigen::Index rows = 1000;

Samples states(double phase) {
  Samples all(rows, joints);
  for (Eigen::Index k = 0; k < rows; ++k)
    for (Eigen::Index j = 0; j < joints; ++j) all(k, j) = std::sin(0.01 * static_cast<double>((j + 1) * k) + phase);
  return all;
}

/// The printed program as a function of many states.
class CompiledProgram {
 public:
  using Run = void (*)(const double* q, const double* dq, const double* ddq, double* torque, long rows);

  explicit CompiledProgram(const Mechanism& mechanism) {
    const auto folder = std::filesystem::temp_directory_path() / ("code_bench." + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const std::string source = folder / "arm.c", library = folder / "arm.so";
    std::ofstream(source)
        << formulas::generate_program(mechanism, {}, formulas::Language::c)
        << "void run(const double *q, const double *dq, const double *ddq, double *tau, long rows) {\n"
           "  double k[constants];\n  prepare(&given, k);\n"
           "  for (long r = 0; r < rows; ++r)\n"
           "    torques(k, q + 6 * r, dq + 6 * r, ddq + 6 * r, tau + 6 * r);\n}\n";
    if (std::system(("cc -O2 -shared -fPIC -o " + library + " " + source + " -lm").c_str()) == 0)
      handle_ = dlopen(library.c_str(), RTLD_NOW);
    std::filesystem::remove_all(folder);
  }
  Run run() const { return handle_ == nullptr ? nullptr : reinterpret_cast<Run>(dlsym(handle_, "run")); }

 private:
  void* handle_ = nullptr;
};

void derivation(benchmark::State& timer) {
  const Mechanism mechanism = six_joint_arm();
  for (auto _ : timer) benchmark::DoNotOptimize(formulas::generate_program(mechanism, {}, formulas::Language::c));
}

void engine(benchmark::State& timer) {
  InverseDynamics door(six_joint_arm());
  const Samples q = states(0), dq = states(1), ddq = states(2);
  for (auto _ : timer) benchmark::DoNotOptimize(door.effort_rows(q, dq, ddq).efforts.data());
}

void program(benchmark::State& timer) {
  const CompiledProgram compiled(six_joint_arm());
  if (compiled.run() == nullptr) return timer.SkipWithError("the program was not compiled");
  const Samples q = states(0), dq = states(1), ddq = states(2);
  Samples torque(rows, joints);
  const Samples expected = InverseDynamics(six_joint_arm()).effort_rows(q, dq, ddq).efforts;
  for (auto _ : timer) {
    compiled.run()(q.data(), dq.data(), ddq.data(), torque.data(), rows);
    benchmark::DoNotOptimize(torque.data());
  }
  if (!((torque - expected).cwiseAbs().maxCoeff() < 1e-10 * expected.cwiseAbs().maxCoeff()))
    timer.SkipWithError("the program and the engine differ");
}

BENCHMARK(derivation)->Unit(benchmark::kMillisecond);
BENCHMARK(engine)->Unit(benchmark::kMicrosecond);
BENCHMARK(program)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace balance

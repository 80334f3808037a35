#pragma once
/// Runs of the mechanisms in configs/, and mechanisms put together in code.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/study.hpp"

#include <random>
#include <string>

namespace published {

using balance::Matrix3;
using balance::Mechanism;
using balance::MotionStatus;
using balance::RunResult;
using balance::Trajectory;
using balance::Vector3;
using balance::VectorX;

balance::Study load(const std::string& file);

/// The trajectory of that name with another number of samples (0: as stated).
Trajectory make_trajectory(const balance::Study& study, const std::string& name, long samples = 0);

/// simulate(), which must end well.
RunResult run(const Mechanism& mechanism, const Trajectory& trajectory);
RunResult run(const std::string& file, const std::string& name, long samples = 0);

/// Column of a joint coordinate.
long coordinate(const Mechanism& mechanism, const std::string& name);
const balance::Metric& metric(const RunResult& result, const std::string& quantity);

// ---- building ----

Mechanism empty(balance::SpaceKind space, const Vector3& gravity);
int add_body(Mechanism& m, double mass, const Vector3& com, const Matrix3& inertia);
int add_body(Mechanism& m, double mass, const Vector3& com, double J);
/// @return the joint's first coordinate
int add_joint(Mechanism& m, balance::JointType type, int first, const Vector3& P, int second, const Vector3& Q,
              const Vector3& axis = Vector3::UnitZ());
void add_disc(Mechanism& m, int body, const Vector3& at, const Vector3& axis, int follows, double ratio, double mass,
              const Matrix3& inertia);
Matrix3 about_z(double J);

/// Cycloidal motion of joint coordinates.
Trajectory joint_motion(const std::vector<balance::CoordinateId>& coordinates, const VectorX& from, const VectorX& to,
                        double duration, long samples);

/// Uniform in [low, high]; the seed stands where the generator is made.
double draw(std::mt19937& random, double low, double high);

}  // namespace published

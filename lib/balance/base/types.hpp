#pragma once
/// Eigen under the names that this program uses. Every quantity is in SI units and world axes unless its
/// name or comment says otherwise.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace balance {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
using MatrixX = Eigen::MatrixXd;
/// One row per sample, contiguous in memory: the layout of the result file.
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace balance

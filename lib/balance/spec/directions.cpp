#include "balance/spec/directions.hpp"

namespace balance::specification {

Vector3E normalized(const Vector3E& v) { return v / sqrt(v.squaredNorm()); }

Matrix3E rotation_about(int axis, const Expression& angle) {
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const Expression c = cos(angle), s = sin(angle);
  Matrix3E rotation = Matrix3E::Identity();
  rotation(next, next) = rotation(last, last) = c;
  rotation(last, next) = s;
  rotation(next, last) = -s;
  return rotation;
}

Matrix3E rotation_from_rpy(const Vector3E& rpy) {
  return rotation_about(2, rpy[2]) * rotation_about(1, rpy[1]) * rotation_about(0, rpy[0]);
}

Matrix3E rotation_from_vector(const Vector3E& v) {
  const Expression angle = sqrt(v.squaredNorm());
  Matrix3E k;
  k << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  k /= angle;
  const Matrix3E identity = Matrix3E::Identity();
  const Matrix3E turned = identity + sin(angle) * k + (1.0 - cos(angle)) * (k * k);
  return choose(equal(angle, 0), identity, turned);
}

Matrix3E rotation_from_quaternion(const std::vector<Expression>& q) {
  Expression square = 0;
  for (const Expression& one : q) square += one * one;
  const Expression scale = 1.0 / sqrt(square);
  const Expression w = q[0] * scale, x = q[1] * scale, y = q[2] * scale, z = q[3] * scale;
  Matrix3E rotation;
  rotation << 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),          //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y);
  return rotation;
}

Matrix3 values_of(const Matrix3E& matrix) {
  return matrix.unaryExpr([](const Expression& x) { return x.value(); });
}

Vector3 values_of(const Vector3E& vector) {
  return vector.unaryExpr([](const Expression& x) { return x.value(); });
}

}  // namespace balance::specification

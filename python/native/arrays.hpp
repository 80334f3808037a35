#pragma once
/// Conversions between the library's matrices and NumPy arrays.

#include "balance/foundation/base/types.hpp"

#include <pybind11/numpy.h>

#include <memory>
#include <utility>
#include <vector>

namespace balance::python {

namespace py = pybind11;

/// Argument type for C-contiguous arrays of doubles; pybind11 copies other arrays.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A read-only view of the memory, which keeps `owner` alive.
template <class T>
py::array read_only(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  py::array_t<T> array(std::move(shape), data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// Moves a matrix into an array without copying its data.
inline py::array owned(Samples&& numbers) {
  auto storage = std::make_unique<Samples>(std::move(numbers));
  const Samples& matrix = *storage;
  const py::capsule owner(storage.release(), [](void* p) { delete static_cast<Samples*>(p); });
  return py::array_t<double>({matrix.rows(), matrix.cols()}, matrix.data(), owner);
}

inline py::array copied(const VectorX& numbers) { return py::array_t<double>(numbers.size(), numbers.data()); }

inline Eigen::Map<const Samples> rows_of(const Numbers& array) {
  return {array.data(), array.shape(0), array.shape(1)};
}

inline VectorX vector_of(const Numbers& array) {
  return Eigen::Map<const VectorX>(array.data(), static_cast<Eigen::Index>(array.size()));
}

}  // namespace balance::python

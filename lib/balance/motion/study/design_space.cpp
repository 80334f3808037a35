#include "balance/motion/study/design_space.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance::study {

namespace {

/// All inputs, with those of the free numbers taken from x.
template <class T>
std::vector<T> evaluate_inputs(const DesignSpace& space, const std::vector<T>& x) {
  std::vector<T> inputs(space.inputs.begin(), space.inputs.end());
  for (std::size_t i = 0; i < space.free_inputs.size(); ++i)
    inputs[static_cast<std::size_t>(space.free_inputs[i])] = x[i];
  return inputs;
}

std::vector<double> evaluate_inputs(const DesignSpace& space, const VectorX& x) {
  if (x.size() != static_cast<Eigen::Index>(space.free_inputs.size()))
    throw std::invalid_argument("expected " + std::to_string(space.free_inputs.size()) +
                                " values of free numbers, found " + std::to_string(x.size()));
  return evaluate_inputs(space, std::vector<double>(x.begin(), x.end()));
}

/// The numbers that stay free differ from those that are fixed at x.
DifferentNumbers restrict_to(const DifferentNumbers& different, const VectorX& x, const std::vector<int>& free) {
  DifferentNumbers restricted{{}, different.taken};
  for (const int number : different.numbers) {
    const auto position = std::find(free.begin(), free.end(), number);
    if (position == free.end())
      restricted.taken.push_back(x[number]);
    else
      restricted.numbers.push_back(static_cast<int>(position - free.begin()));
  }
  return restricted;
}

}  // namespace

DesignSpace::DesignSpace(Study study, std::shared_ptr<const Recording> recorded)
    : start(std::move(study)),
      recording(std::move(recorded)),
      inputs(recording->inputs),
      free_inputs(recording->free) {}

VectorX DesignSpace::start_values() const {
  VectorX x(static_cast<Eigen::Index>(start.free_numbers.size()));
  for (std::size_t i = 0; i < start.free_numbers.size(); ++i)
    x[static_cast<Eigen::Index>(i)] = start.free_numbers[i].start;
  return x;
}

DesignInstance DesignSpace::instantiate(const VectorX& x) const {
  const std::vector<double> all_inputs = evaluate_inputs(*this, x);
  const RecordedValues<double> values(*recording, all_inputs);
  DesignInstance instance{values.mechanism(), values.trajectories()};
  if (assembly_mode) assembly_mode->select(all_inputs, instance);
  return instance;
}

Study DesignSpace::study_at(const VectorX& x) const {
  DesignInstance instance = instantiate(x);
  Study study = start;
  study.mechanism = std::move(instance.mechanism);
  study.trajectories = std::move(instance.trajectories);
  return study;
}

ParametricMechanism DesignSpace::parametric() const {
  return study::make_parametric_mechanism(start_values(), [&](const std::vector<Expression>& x) {
    return RecordedValues<Expression>(*recording, evaluate_inputs(*this, x)).mechanism();
  });
}

DesignSpace DesignSpace::with_rows(const std::vector<int>& rows) const {
  DesignSpace chosen = *this;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    CatalogueChoice& choice = chosen.start.catalogue_choices[k];
    choice.row = rows[k];
    choice.is_free = false;
    for (const CatalogueColumn& column : choice.columns)
      if (column.input >= 0)
        chosen.inputs[static_cast<std::size_t>(column.input)] = column.values[static_cast<std::size_t>(rows[k])];
  }
  chosen.start = chosen.study_at(start_values());
  return chosen;
}

DesignSpace DesignSpace::fix_others(const VectorX& x, const std::vector<int>& free_indices) const {
  DesignSpace subspace = *this;
  subspace.start = study_at(x);
  subspace.start.free_numbers.clear();
  subspace.free_inputs.clear();
  subspace.inputs = evaluate_inputs(*this, x);
  for (const int i : free_indices) {
    FreeNumber number = start.free_numbers[static_cast<std::size_t>(i)];
    number.start = x[i];
    subspace.start.free_numbers.push_back(std::move(number));
    subspace.free_inputs.push_back(free_inputs[static_cast<std::size_t>(i)]);
  }
  for (DifferentNumbers& different : subspace.start.design.all_different)
    different = restrict_to(different, x, free_indices);
  return subspace;
}

}  // namespace balance::study

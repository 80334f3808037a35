#include "balance/motion/configuration_text.hpp"

#include "balance/model/coordinates.hpp"

namespace balance {

template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y) {
  constexpr std::size_t max_listed_coordinates = 12;  // a sentence is to be read
  std::string out;
  for (std::size_t c = 0; c < tree.coordinate_expressions.size() && c < max_listed_coordinates; ++c) {
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (!source.has_terms() || tree.is_floating[c]) continue;
    const double value = source.value(y);
    const auto coordinate = static_cast<int>(c);
    const double round_off =
        pose_round_off * (is_length_coordinate(mechanism, coordinate) ? tree.characteristic_length : 1);
    out += (out.empty() ? "" : ", ") + mechanism.coordinates[c].name + " " +
           format_coordinate(mechanism, coordinate, value, round_off);
  }
  return out;
}

template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance

#include "balance/motion/configuration_text.hpp"

#include "balance/model/coordinates.hpp"

namespace balance {

template <class S>
std::string configuration_text(const Mechanism& mechanism, const Tree<S>& tree, const double* y) {
  constexpr std::size_t most = 12;  // a sentence is to be read
  std::string out;
  for (std::size_t c = 0; c < tree.sources.size() && c < most; ++c) {
    const LinearQuantity& source = tree.sources[c];
    if (!source.depends() || tree.floats[c]) continue;
    const double value = source.value(y);
    const auto coordinate = static_cast<int>(c);
    const double round_off = pose_round_off * (is_length(mechanism, coordinate) ? tree.length : 1);
    out += (out.empty() ? "" : ", ") + mechanism.coordinates[c].name + " " +
           coordinate_text(mechanism, coordinate, value, round_off);
  }
  return out;
}

template std::string configuration_text<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
template std::string configuration_text<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance

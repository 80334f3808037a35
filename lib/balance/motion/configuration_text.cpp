#include "balance/motion/configuration_text.hpp"

namespace balance {

template <class S>
std::string configuration_text(const Mechanism& mechanism, const Tree<S>& tree, const double* y) {
  constexpr std::size_t most = 12;  // a sentence is to be read
  std::string out;
  for (std::size_t c = 0; c < tree.sources.size() && c < most; ++c) {
    const LinearQuantity& source = tree.sources[c];
    if (!source.depends() || tree.floats[c]) continue;
    const double value = source.value(y);
    const bool angle = mechanism.coordinates[c].kind == CoordinateKind::angle;
    out += (out.empty() ? "" : ", ") + mechanism.coordinates[c].name + " " +
           (angle ? angle_text(value, mechanism.units, pose_round_off)
                  : length_text(value, mechanism.units, pose_round_off * tree.length));
  }
  return out;
}

template std::string configuration_text<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
template std::string configuration_text<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance

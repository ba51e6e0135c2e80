#include "material/tangent.hpp"

#include "material/laws.hpp"

namespace matpoint {
namespace {

template <int Dim, class... Laws>
TangentFunction<Dim> function_at(int index, std::tuple<Laws...>*) {
  static constexpr TangentFunction<Dim> all[] = {&evaluate_tangent<Dim, Laws>...};
  return index < 0 ? nullptr : all[index];
}

}  // namespace

template <int Dim>
TangentFunction<Dim> tangent_function(const Material& material) {
  return function_at<Dim>(material.law_index(), static_cast<AllLaws*>(nullptr));
}

template TangentFunction<2> tangent_function<2>(const Material&);
template TangentFunction<3> tangent_function<3>(const Material&);

}  // namespace matpoint

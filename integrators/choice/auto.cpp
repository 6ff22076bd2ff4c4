#include "integrators/choice/auto.h"

#include "framework/core/check.h"
#include "integrators/registry.h"

namespace etendue {

namespace {

constexpr const char* own_name = "auto";

Effort effort_for(const AutoParams& params, const Effort& told) { return params.seconds > 0 ? Effort{params.seconds} : told; }

class Auto final : public Integrator {
 public:
  explicit Auto(const AutoParams& params) : params_(params) {}

  void prepare(RenderContext& context) override {
    const Effort told = context.effort;
    context.effort = effort_for(params_, told);
    choice_ = choose_method(context, run_pilot_within_effort(context), params_.bias);
    context.effort = told;
    method_ = find_integrator(choice_.name, {}).make(choice_.params);
    method_->prepare(context);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    CHECK(method_ != nullptr);
    method_->iteration(context, index, film);
  }

  // Before anything is chosen, what holds of each method that may be.
  Expectation expectation() const override {
    if (method_) return method_->expectation();
    return {params_.bias == BiasAllowed::none ? Bias::unbiased : Bias::consistent, -1, 0.02, "that of the method it chooses"};
  }
  Cache* cache() override { return method_ ? method_->cache() : nullptr; }
  const MethodChoice* choice() const override { return method_ ? &choice_ : nullptr; }

 private:
  AutoParams params_;
  MethodChoice choice_;
  std::unique_ptr<Integrator> method_;
};

}  // namespace

IntegratorEntry auto_entry() {
  return integrator_entry<Auto, AutoParams>(own_name,
                                            "the method that a pilot finds best for scene and budget, and its parameters");
}

Effort effort_chosen_for(const std::string& method, const ParamMap& params, const Effort& told) {
  return method == own_name ? effort_for(read_params<AutoParams>(params, method), told) : told;
}

}  // namespace etendue

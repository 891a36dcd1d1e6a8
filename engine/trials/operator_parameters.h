#pragma once

// The parameters of one simulated person.

namespace palpate {

// The parameters of a simulated person. An operator file gives the range of each parameter but the
// last, and the source of the range (operator_file.h).
struct OperatorParameters {
  double sight_delay_s = 0.15;            // > 0, from a picture to the hand
  double replan_s = 0.35;                 // > 0, for Following::kReplan
  double gain_per_s = 3.0;                // >= 0, of the correction along the way
  double force_noise = 0.05;              // >= 0, standard deviation as a share of the hand's force
  double intention_noise_m = 2e-3;        // >= 0, standard deviation along each axis
  double intention_noise_Hz = 1.0;        // > 0, its natural frequency
  double hand_stiffness_N_per_m = 443.0;  // > 0
  double hand_damping_Ns_per_m = 15.0;    // >= 0
  double press_depth_m = 8e-3;            // > 0, of the target inside the wall
  double speed_m_per_s = 0.045;           // >= 0, along the way
  double comfortable_depth_m = 5e-3;      // > 0, beyond press_depth_m: deeper, the hand slows
};

}  // namespace palpate

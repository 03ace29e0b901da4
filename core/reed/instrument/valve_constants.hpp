#pragma once

#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// Coefficients of the valve and of the lumped elements at the bore's input (cone, cup) for one
/// internal time step T. Symbols are those of docs/theory/greed.md, SI units.
///
/// Displacements are measured along `direction`, so that a valve with a stop opens towards positive
/// values whether it is blown open or closed; the signs of the forces follow.
struct ValveConstants {
  double period = 0, rate = 0;    // T, 1/T
  double direction = 1;           // +1: open at theta > 0, as the swinging valve; -1: open at theta
                                  // < 0
  double rest_opening = 0;        // |x_0|; the swinging valve's x_0
  double lowest = 0, highest = 0; // stop and limit, as deflection from rest, m
  double width = 0, leak = 0;     // w, A_leak
  double mouth_area = 0;          // w lambda_m along the direction
  double bore_area = 0;           // w lambda_b along the direction
  double swept_area = 0;          // as bore_area, or 0 when the sweep is off
  double flow_area = 0;           // w mu
  double mass = 0, damping = 0;   // m, m/Q
  double decay = 0;               // 1/4Q^2
  double density = 0;             // rho
  double specific_volume = 0;     // 1/rho
  double inertia = 0;             // rho lambda/(theta T)
  double jet_gain = 1;            // 1/theta of the jet's theta rule
  double channel_length = 0;      // lambda
  double restitution = 0;
  double wave_admittance = 0; // 2/Z_0
  double port_admittance = 0; // y_p = 1/Z_0 + T/2M + 2C/T
  double rigid_impedance = 0; // 1/y_p
  double inertance_rate = 0;  // T/2M, cone
  double compliance_rate = 0; // 2C/T, cup
  double angle_scale = 1;     // theta = (deflection + rest opening) angle_scale
  bool swinging = false;
  /// No cone, no cup and no force of the flow on the valve.
  [[nodiscard]] bool plain_port() const noexcept {
    return !(flow_area > 0) && !(inertance_rate > 0) && !(compliance_rate > 0);
  }
  bool paper = false; // FlowMethod::kPaper

  static ValveConstants from(const Parameters& parameters, const BoreDesign& bore,
                             double internal_rate) noexcept;
  /// Linear interpolation, share in 0..1, between two sets of the same rate; switches are those of
  /// `to`.
  static ValveConstants interpolate(const ValveConstants& from, const ValveConstants& to,
                                    double share) noexcept;
};

} // namespace tactus::reed

// $motors to $joints for ros2_control: a plugin of type "$type".
//
// Made by pmjac_pin. Build it with $header beside it into a library of your package, and export
// its plugin description (pluginlib_export_plugin_description_file(transmission_interface ...)):
//
//   <library path="...">
//     <class name="$type" type="$type::Loader"
//            base_class_type="transmission_interface::TransmissionLoader"/>
//   </library>
//
// In the URDF, joints and actuators in this order: $joints; $motors.
//
// Ratios change with the pose, so velocity and effort need a position beside them, which says where
// they are meant: measured positions where efforts or velocities are commanded. Where there is no
// pose of the transmission at these positions, what it sets are NaN, and status() says why.
#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/hardware_info.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "transmission_interface/exception.hpp"
#include "transmission_interface/transmission.hpp"
#include "transmission_interface/transmission_loader.hpp"

#include "$header"

namespace $type
{
using transmission_interface::ActuatorHandle;
using transmission_interface::Exception;
using transmission_interface::JointHandle;

constexpr std::size_t kCount = $count;
using Numbers = std::array<double, kCount>;

// Handles of one kind, position, velocity and effort, in the order of the names; or none of a kind.
template <class Handle>
class Side
{
public:
  void take(const std::vector<Handle> & handles, const std::string & what)
  {
    std::vector<std::string> names;
    for (const Handle & handle : handles) {
      const std::string name = handle.get_prefix_name();
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(name);
      }
    }
    if (names.size() != kCount) {
      throw Exception(what + ": handles of " + std::to_string(kCount) + " names expected");
    }
    position = of(handles, names, hardware_interface::HW_IF_POSITION, what);
    velocity = of(handles, names, hardware_interface::HW_IF_VELOCITY, what);
    effort = of(handles, names, hardware_interface::HW_IF_EFFORT, what);
    if (position.empty()) {
      throw Exception(what + ": position is needed, from which the ratios follow");
    }
  }

  std::vector<Handle> position, velocity, effort;

private:
  static std::vector<Handle> of(
    const std::vector<Handle> & handles, const std::vector<std::string> & names,
    const std::string & interface, const std::string & what)
  {
    std::vector<Handle> found;
    for (const std::string & name : names) {
      for (const Handle & handle : handles) {
        if (handle.get_prefix_name() == name && handle.get_interface_name() == interface && handle) {
          found.push_back(handle);
        }
      }
    }
    if (!found.empty() && found.size() != kCount) {
      throw Exception(what + ": " + interface + " of each name expected once, or of none");
    }
    return found;
  }
};

// joint = model's joint + offset; actuator = model's motor * reduction.
class Transmission : public transmission_interface::Transmission
{
public:
  Transmission(const Numbers & reduction, const Numbers & offset)
  : reduction_(reduction), offset_(offset)
  {
    for (const double each : reduction_) {
      if (each == 0.0) {
        throw Exception("mechanical_reduction of an actuator is 0");
      }
    }
  }

  void configure(
    const std::vector<JointHandle> & joint_handles,
    const std::vector<ActuatorHandle> & actuator_handles) override
  {
    joints_.take(joint_handles, "joints");
    actuators_.take(actuator_handles, "actuators");
    if (joints_.velocity.size() != actuators_.velocity.size() ||
      joints_.effort.size() != actuators_.effort.size())
    {
      throw Exception("velocity and effort are of joints and actuators, or of neither");
    }
  }

  void actuator_to_joint() override
  {
    Numbers motors = over(read(actuators_.position), reduction_), found;
    status_ = ${name}_at_motors(motors.data(), &pose_);
    for (std::size_t k = 0; k < kCount; ++k) {
      joints_.position[k].set_value(known(pose_.joints[k] + offset_[k]));
    }
    if (!joints_.velocity.empty()) {
      const Numbers rates = over(read(actuators_.velocity), reduction_);
      ${name}_joint_rates(&pose_, rates.data(), found.data());
      write(found, joints_.velocity);
    }
    if (!joints_.effort.empty()) {
      const Numbers efforts = times(read(actuators_.effort), reduction_);
      ${name}_joint_efforts(&pose_, efforts.data(), found.data());
      write(found, joints_.effort);
    }
  }

  void joint_to_actuator() override
  {
    Numbers joints = read(joints_.position), found;
    for (std::size_t k = 0; k < kCount; ++k) {
      joints[k] -= offset_[k];
    }
    status_ = ${name}_at_joints(joints.data(), &pose_);
    for (std::size_t k = 0; k < kCount; ++k) {
      actuators_.position[k].set_value(known(pose_.motors[k] * reduction_[k]));
    }
    if (!actuators_.velocity.empty()) {
      ${name}_motor_rates(&pose_, read(joints_.velocity).data(), found.data());
      write(times(found, reduction_), actuators_.velocity);
    }
    if (!actuators_.effort.empty()) {
      ${name}_motor_efforts(&pose_, read(joints_.effort).data(), found.data());
      write(over(found, reduction_), actuators_.effort);
    }
  }

  std::size_t num_actuators() const override {return kCount;}
  std::size_t num_joints() const override {return kCount;}

  // Of the last pose: ${NAME}_OK, or why there is none.
  int status() const {return status_;}

private:
  double known(double value) const
  {
    return status_ == ${NAME}_OK ? value : std::numeric_limits<double>::quiet_NaN();
  }

  template <class Handle>
  static Numbers read(const std::vector<Handle> & handles)
  {
    Numbers values;
    std::transform(
      handles.begin(), handles.end(), values.begin(),
      [](const Handle & handle) {return handle.get_value();});
    return values;
  }

  template <class Handle>
  void write(const Numbers & values, std::vector<Handle> & handles) const
  {
    for (std::size_t k = 0; k < kCount; ++k) {
      handles[k].set_value(known(values[k]));
    }
  }

  static Numbers times(Numbers values, const Numbers & factors)
  {
    for (std::size_t k = 0; k < kCount; ++k) {
      values[k] *= factors[k];
    }
    return values;
  }

  static Numbers over(Numbers values, const Numbers & factors)
  {
    for (std::size_t k = 0; k < kCount; ++k) {
      values[k] /= factors[k];
    }
    return values;
  }

  Numbers reduction_, offset_;
  Side<JointHandle> joints_;
  Side<ActuatorHandle> actuators_;
  ${name}_pose pose_{};
  int status_ = ${NAME}_NOT_CONVERGED;
};

class Loader : public transmission_interface::TransmissionLoader
{
public:
  std::shared_ptr<transmission_interface::Transmission> load(
    const hardware_interface::TransmissionInfo & info) override
  {
    if (info.joints.size() != kCount || info.actuators.size() != kCount) {
      throw Exception("$type: as many joints and actuators expected as there are: $count each");
    }
    Numbers reduction, offset;
    for (std::size_t k = 0; k < kCount; ++k) {
      reduction[k] = info.actuators[k].mechanical_reduction;
      offset[k] = info.joints[k].offset;
      if (info.joints[k].mechanical_reduction != 1.0) {
        throw Exception("$type: the mechanical_reduction of a joint is 1; an actuator's may be other");
      }
    }
    return std::make_shared<Transmission>(reduction, offset);
  }
};
}  // namespace $type

PLUGINLIB_EXPORT_CLASS($type::Loader, transmission_interface::TransmissionLoader)

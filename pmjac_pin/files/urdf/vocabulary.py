"""The words of URDF: those of ROS, of URDF+, and what Gazebo, Drake and others put beside them."""

from __future__ import annotations

from pmjac_pin.files.vocabulary import Vocabulary

URDF_WORDS = Vocabulary("""
robot name version : link joint material transmission ros2_control gazebo loop constraint coupling
  loop_joint drake:ball_constraint drake:weld_constraint drake:coupler_constraint
  drake:collision_filter_group* frame*
  drake:linear_bushing_rpy! drake:linear_spring_damper! drake:tendon_constraint! drake:joint!
  sensor* group* disable_collisions* mujoco
mujoco : compiler* option* size*
link name type* : inertial visual collision* contact* self_filter* collision_checking* gravity*
  kinematic* surface* self_collision_checking* velocity_decay* laser_retro*
inertial : origin mass inertia
mass value
inertia ixx ixy ixz iyy iyz izz
origin xyz rpy quat_xyzw
visual name : origin geometry material verbose* drake:*
geometry name* : box cylinder capsule sphere mesh drake:*
box size
cylinder radius length
capsule radius length
sphere radius
mesh filename* scale* : drake:*
material name : color texture* specular*
color rgba
joint name type independent dont_collapse* id* : origin parent child axis limit dynamics mimic
  calibration* safety_controller* joint_properties* hardwareInterface* drake:rotor_inertia*
  drake:gear_ratio* drake:controller_gains*
axis xyz
parent link
child link
limit lower upper effort velocity acceleration* jerk* command_effort* current* gear_velocity*
  drake:acceleration*
dynamics damping friction D* K* mu_coulomb* mu_viscous* armature* stiffness* spring_reference*
  spring_stiffness*
mimic joint multiplier offset
loop name type : predecessor successor parent child parent_origin child_origin axis parent_axis
  child_axis
constraint name type : predecessor successor parent child parent_origin child_origin axis
  parent_axis child_axis
coupling name : predecessor successor ratio
coupling/predecessor link
coupling/successor link
ratio value
predecessor link : origin
successor link : origin
loop/parent link : origin
loop/child link : origin
constraint/parent link : origin
constraint/child link : origin
parent_origin xyz rpy
child_origin xyz rpy
parent_axis xyz
child_axis xyz
loop_joint name type : link1 link2 axis
link1 link xyz rpy
link2 link xyz rpy
drake:ball_constraint : drake:ball_constraint_body_A drake:ball_constraint_body_B
  drake:ball_constraint_p_AP drake:ball_constraint_p_BQ
drake:ball_constraint_body_A name
drake:ball_constraint_body_B name
drake:ball_constraint_p_AP value
drake:ball_constraint_p_BQ value
transmission name type* : type* actuator* joint* mechanicalReduction* leftActuator* rightActuator*
  flexJoint* rollJoint* use_simulated_gripper_joint* plugin* compensator* gap_joint! passive_joint!
ros2_control name type* rw_rate* is_async* : hardware* joint sensor* gpio* transmission*
hardware : plugin*
group : joint*
ros2_control/joint name mimic : param command_interface* state_interface* plugin*
param name*
gazebo reference : joint plugin! collision* visual* material* sensor* light* self_collide*
  selfCollide* gravity* turnGravityOff* static* kinematic* enable_wind* velocity_decay*
  mu* mu1* mu2* fdir1* kp* kd* minDepth* min_depth* maxVel* max_vel* maxContacts* max_contacts*
  soft_cfm* soft_erp* softCfm* softErp* cfm* erp* bounce* friction* laserRetro* laser_retro*
  dampingFactor* implicitSpringDamper* springStiffness* springReference* stopCfm* stopErp* stopKp*
  stopKd* fudgeFactor* provideFeedback* provide_feedback* cfmDamping* initial_joint_position*
  initialJointPosition* preserveFixedJoint* disableFixedJointLumping* canonicalBody* audio*
  allow_auto_disable* physics* dynamics* limit* surface* controller:* sensor:* interface:*
""")

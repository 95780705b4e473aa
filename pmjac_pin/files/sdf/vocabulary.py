"""The words of SDFormat 1.4 to 1.12, and Drake's."""

from __future__ import annotations

from pmjac_pin.files.vocabulary import Vocabulary

SDF_WORDS = Vocabulary("""
sdf version : model world actor* light*
world name : model include frame* light* gravity* magnetic_field* atmosphere* audio* wind*
  gui* physics* scene* road* spherical_coordinates* state* population* actor* plugin! joint!
include : uri name* pose* static* placement_frame* plugin!
state : model*
state/model : joint*
gui : plugin*
model name canonical_link placement_frame : static pose frame link joint include model gripper!
  self_collide* allow_auto_disable* enable_wind* drake:ball_constraint drake:weld_constraint
  drake:coupler_constraint
  drake:collision_filter_group* drake:linear_bushing_rpy! drake:linear_spring_damper!
  drake:tendon_constraint! drake:joint! plugin!
pose relative_to frame rotation_format degrees
frame name attached_to : pose
link name : pose inertial visual collision* sensor* must_be_base_link* gravity* enable_wind*
  self_collide* kinematic* velocity_decay* projector* audio_sink* audio_source* battery* light*
  particle_emitter*
visual name : pose geometry material cast_shadows* laser_retro* transparency* visibility_flags*
  meta* plugin! drake:*
geometry : box capsule cylinder sphere mesh empty* cone* ellipsoid* heightmap* image* plane*
  polyline* drake:*
box : size
capsule : radius length
cylinder : radius length
sphere : radius
mesh : uri scale* submesh* convex_decomposition* drake:*
material : diffuse ambient* specular* emissive* shininess* script* shader* lighting* pbr*
  render_order* double_sided* drake:*
inertial auto : pose mass inertia density* auto_inertia_params* fluid_added_mass* frame*
inertia : ixx ixy ixz iyy iyz izz
joint name type : parent child pose gearbox_ratio gearbox_reference_body thread_pitch
  screw_thread_pitch axis axis2 physics* sensor* drake:mimic drake:rotor_inertia*
  drake:gear_ratio* drake:controller_gains*
axis : xyz use_parent_model_frame limit mimic dynamics* initial_position*
axis2 : xyz use_parent_model_frame limit mimic dynamics* initial_position*
xyz expressed_in
limit : lower upper effort velocity stiffness* dissipation* drake:acceleration*
mimic joint axis : multiplier offset reference
drake:mimic joint multiplier offset
drake:ball_constraint : drake:ball_constraint_body_A drake:ball_constraint_body_B
  drake:ball_constraint_p_AP drake:ball_constraint_p_BQ
""")

"""The words of MJCF, as MuJoCo 4.0 prints them and as older versions had them."""

from __future__ import annotations

from pmjac_pin.files.vocabulary import Vocabulary

_ACTUATORS = (
    *("general", "motor", "position", "velocity", "intvelocity", "orientation", "pid", "damper"),
    *("cylinder", "muscle", "adhesion", "dcmotor", "plugin"),
)
_ACTUATOR = """
name joint jointinparent class* actdim* actearly* actlimited* actrange* area* armature* bias*
  biasprm* biastype* body* cogging* controller* cranklength* cranksite* ctrllimited* ctrlrange*
  damping* dampratio* delay* diameter* dynprm* dyntype* ffrange* force* forcelimited* forcerange*
  fpmax* fvmax* gain* gainprm* gaintype* gear group* imax* inductance* inheritrange* input*
  instance* interp* ki* kp* kv* lengthrange* lmax* lmin* lugre* motorconst* nominal* nsample*
  plugin* posrange* range* refsite* resistance* saturation* scale* site* slewmax* slidersite*
  tausmooth* tendon* thermal* timeconst* user* velrange* vmax*
"""

_CARRIED = (
    "body frame geom site joint freejoint inertial camera* light* plugin! attach composite "
    "flexcomp replicate"
)

MJCF_WORDS = Vocabulary(
    f"""
mujoco model : compiler option default worldbody equality actuator keyframe asset tendon contact*
  custom* deformable! extension! sensor* size* statistic* visual*
sensor : plugin*
asset : model mesh* hfield* skin* texture* material*
model name file content_type*
worldbody : {_CARRIED}
frame name pos quat axisangle euler xyaxes zaxis childclass : {_CARRIED}
replicate count offset euler sep childclass : {_CARRIED}
attach model body frame prefix
tendon : fixed spatial
fixed name class* actuatorfrclimited* actuatorfrcrange* armature* damping* frictionloss* group*
  limited* margin* range* solimpfriction* solimplimit* solreffriction* solreflimit* springlength*
  springyield* stiffness* user* : joint
fixed/joint joint coef
spatial name class* actuatorfrclimited* actuatorfrcrange* armature* damping* frictionloss* group*
  limited* margin* material* range* rgba* solimpfriction* solimplimit* solreffriction* solreflimit*
  springlength* springyield* stiffness* user* width* : site geom pulley
spatial/site site
spatial/geom geom sidesite
pulley divisor
equality : connect weld joint tendon flex* flexstrain* flexvert* distance*
keyframe : key
compiler angle eulerseq autolimits coordinate alignfree inertiafromgeom inertiagrouprange
  boundmass boundinertia balanceinertia settotalmass assetdir* conflict* discardvisual* fitaabb*
  fusestatic* meshdir* passthrough* savecanonical* savecompiled* saveinertial* strippath*
  texturedir* usethread* convexhull* exactmeshinertia* : lengthrange*
option actuatorgroupdisable* ccd_iterations* ccd_tolerance* cone* density* gravity* impratio*
  integrator* iterations* jacobian* ls_iterations* ls_tolerance* magnetic* noslip_iterations*
  noslip_tolerance* o_friction* o_margin* o_solimp* o_solref* sdf_initpoints* sdf_iterations*
  sleep_tolerance* solver* timestep* tolerance* viscosity* wind* apirate* collision*
  mpr_iterations* mpr_tolerance* : flag
flag equality constraint actuation* autoreset* clampctrl* contact* damper* diagexact* energy*
  eulerdamp* filterparent* frictionloss* fwdinv* gravity* invdiscrete* ipc* island* limit*
  midphase* multiccd* nativeccd* override* refsafe* sensor* sleep* speculative* spring* warmstart*
body name pos quat axisangle euler xyaxes zaxis childclass mocap fuse* gravcomp* simple* sleep*
  user* : {_CARRIED}
inertial mass diaginertia fullinertia pos quat axisangle euler xyaxes zaxis
joint name class type pos axis ref range limited actuatorfrclimited* actuatorfrcrange*
  actuatorgravcomp* armature damping* frictionloss* group* margin* solimpfriction* solimplimit*
  solreffriction* solreflimit* springdamper springref* springyield* stiffness user*
freejoint name align group*
geom name class pos quat axisangle euler xyaxes zaxis type size fromto mesh mass density group
  rgba shellinertia adhesion* castshadow* conaffinity* condim* contype* fitscale* fluidcoef*
  fluidshape* friction* gap* hfield* margin* material* priority* solimp* solmix* solref*
  surfacevel* user* : plugin*
site name class pos quat axisangle euler xyaxes zaxis fromto type size group* material* mesh* rgba*
  user*
default class : default joint geom site equality mesh* texture* material* camera* light* pair*
  tendon* general* motor* position* velocity* intvelocity* orientation* pid* damper* cylinder*
  muscle* adhesion* dcmotor*
default/equality active solimp* solref*
connect name class active body1 body2 site1 site2 anchor solimp* solref*
weld name class active body1 body2 site1 site2 anchor relpose torquescale solimp* solref*
equality/joint name class active joint1 joint2 polycoef solimp* solref*
equality/tendon name class active tendon1 tendon2 polycoef solimp* solref*
key name qpos act* ctrl* mpos* mquat* plastic* qvel* time*
actuator : """
    + " ".join(_ACTUATORS)
    + "".join(f"\nactuator/{tag} {_ACTUATOR.strip()} : config*" for tag in _ACTUATORS)
)

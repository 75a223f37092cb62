//! The classes of components with the names of their arguments, in order.

/// A class of component; the names are xija's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Class {
    Node,
    AcisFPtemp,
    Coupling,
    RadiativeCoupling,
    HeatSink,
    HeatSinkRef,
    Delay,
    Mask,
    MaskBox,
    Pitch,
    Roll,
    Eclipse,
    SimZ,
    DetectorHousingHeater,
    TelemData,
    CmdStatesData,
    SolarHeat,
    SolarHeatMulplicative,
    SolarHeatAcisCameraBody,
    SolarHeatHrc,
    SolarHeatHrcOpts,
    SolarHeatHrcMult,
    SolarHeatOffNomRoll,
    /// Solar heating by position of the instrument module; the arguments are the same for all of them.
    AllSimZSolarHeat,
    AcisPsmcSolarHeat,
    HrcISAcisSimZSolarHeat,
    AcisISHrcSimZSolarHeat,
    EarthHeat,
    AcisDpaStatePower,
    AcisDpaPower,
    StepFunctionPower,
    MsidStatePower,
    PropHeater,
    ThermostatHeater,
}

const TELEMETRY: &str = "msid mval data fetch_attr units";
const SOLAR: &str = "node pitch_comp eclipse_comp P_pitches Ps dPs var_func tau ampl bias epoch dP_pitches";
const SOLAR_HRC: &str = "node simz_comp pitch_comp eclipse_comp P_pitches Ps dPs var_func tau ampl bias epoch hrci_bias hrcs_bias dP_pitches";
const SOLAR_SIM_Z: &str = "node pitch_comp simz_comp dh_heater_comp eclipse_comp P_pitches P_vals dP_pitches dPs var_func \
                           tau ampl epoch dh_heater";

/// Name in the file, class, arguments in order.
const CLASSES: &[(&str, Class, &str)] = &[
    ("Node", Class::Node, "msid sigma quant predict mask name data fetch_attr units"),
    ("AcisFPtemp", Class::AcisFPtemp, "mask"),
    ("Coupling", Class::Coupling, "node1 node2 tau"),
    ("RadiativeCoupling", Class::RadiativeCoupling, "node1 node2 factor"),
    ("HeatSink", Class::HeatSink, "node T tau"),
    ("HeatSinkRef", Class::HeatSinkRef, "node T tau T_ref"),
    ("Delay", Class::Delay, "node delay"),
    ("Mask", Class::Mask, "node op val min_ max_"),
    ("MaskBox", Class::MaskBox, "node val0 val1 min_ max_"),
    ("Pitch", Class::Pitch, ""),
    ("Roll", Class::Roll, ""),
    ("Eclipse", Class::Eclipse, ""),
    ("SimZ", Class::SimZ, ""),
    ("DetectorHousingHeater", Class::DetectorHousingHeater, ""),
    ("TelemData", Class::TelemData, TELEMETRY),
    ("CmdStatesData", Class::CmdStatesData, TELEMETRY),
    ("SolarHeat", Class::SolarHeat, SOLAR),
    ("SolarHeatMulplicative", Class::SolarHeatMulplicative, SOLAR),
    (
        "SolarHeatAcisCameraBody",
        Class::SolarHeatAcisCameraBody,
        "node pitch_comp eclipse_comp P_pitches Ps dPs var_func tau ampl bias epoch dh_heater_comp dh_heater_bias dP_pitches",
    ),
    (
        "SolarHeatHrc",
        Class::SolarHeatHrc,
        "node simz_comp pitch_comp eclipse_comp P_pitches Ps dPs var_func tau ampl bias epoch hrc_bias dP_pitches",
    ),
    ("SolarHeatHrcOpts", Class::SolarHeatHrcOpts, SOLAR_HRC),
    ("SolarHeatHrcMult", Class::SolarHeatHrcMult, SOLAR_HRC),
    ("SolarHeatOffNomRoll", Class::SolarHeatOffNomRoll, "node pitch_comp roll_comp eclipse_comp P_plus_y P_minus_y"),
    ("AllSimZSolarHeat", Class::AllSimZSolarHeat, SOLAR_SIM_Z),
    ("AcisPsmcSolarHeat", Class::AcisPsmcSolarHeat, SOLAR_SIM_Z),
    ("HrcISAcisSimZSolarHeat", Class::HrcISAcisSimZSolarHeat, SOLAR_SIM_Z),
    ("AcisISHrcSimZSolarHeat", Class::AcisISHrcSimZSolarHeat, SOLAR_SIM_Z),
    (
        "EarthHeat",
        Class::EarthHeat,
        "node orbitephem0_x orbitephem0_y orbitephem0_z aoattqt1 aoattqt2 aoattqt3 aoattqt4 solarephem0_x solarephem0_y \
         solarephem0_z k k2",
    ),
    ("AcisDpaStatePower", Class::AcisDpaStatePower, "node mult fep_count ccd_count vid_board clocking pow_states"),
    ("AcisDpaPower", Class::AcisDpaPower, "node k"),
    ("StepFunctionPower", Class::StepFunctionPower, "node time P id"),
    ("MsidStatePower", Class::MsidStatePower, "node state_msid state_val P"),
    ("PropHeater", Class::PropHeater, "node node_control k T_set"),
    ("ThermostatHeater", Class::ThermostatHeater, "node node_control P T_set"),
];

impl Class {
    /// The class of a name in the file.
    pub fn of(name: &str) -> Option<Self> {
        CLASSES.iter().find(|row| row.0 == name).map(|row| row.1)
    }

    /// Names of the arguments in order.
    pub fn arguments(self) -> impl Iterator<Item = &'static str> {
        CLASSES.iter().find(|row| row.1 == self).map_or("", |row| row.2).split_whitespace()
    }

    /// The names in the file of all classes.
    pub fn names() -> impl Iterator<Item = &'static str> {
        CLASSES.iter().map(|row| row.0)
    }

    /// Whether it gives the temperature of a node of the network.
    pub fn is_node(self) -> bool {
        matches!(self, Self::Node | Self::AcisFPtemp)
    }
}

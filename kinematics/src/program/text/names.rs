//! Names that a controller takes: form, length, and words that the language keeps for itself.

use crate::program::check::WriteError;

/// Words of the RAPID grammar (*RAPID Overview*, basic characteristics, reserved words), `TASK` included, which stands
/// before declarations. Case does not count.
const RAPID_RESERVED: &str = "\
    ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC \
    ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT \
    NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP TRUE TRYNEXT UNDO \
    VAR VIEWONLY WHILE WITH XOR";

/// Instructions, functions, types and data that every RAPID controller has installed, and which a program of ours, or
/// one that is loaded beside it, may want. A global name of ours must be none of them.
const RAPID_INSTALLED: &str = "\
    Abs AccSet ActUnit Add BitAnd bool byte CJointT Clear ClkReset ClkStart ClkStop clock Close confdata ConfJ ConfL \
    CPos CRobT DeactUnit Decr DefFrame dionum Distance EOffsOff EOffsOn EOffsSet ERRNO errnum EulerZYX extjoint fine \
    GripLoad high IDelete IDisable IEnable Incr inpos100 inpos20 inpos50 INTNO intnum IODisable IOEnable jointtarget \
    Load load0 loaddata LoadId low MechUnitLoad mecunit MoveAbsJ MoveC MoveCDO MoveJ MoveJDO MoveL MoveLDO num Offs \
    Open orient OrientZYX PathAccLim PDispOff PDispOn PDispSet pos pose PoseInv PoseMult PulseDO RelTool Reset \
    RestoPath ROB_ID robjoint robtarget Round Save SearchL Set SetAO SetDO SetGO signalai signalao signaldi signaldo \
    signalgi signalgo SingArea SoftAct SoftDeact speeddata StartLoad StartMove Stop StopMove StorePath string \
    StrMatch switch tool0 tooldata TPErase TPReadNum TPWrite triggdata TriggEquip TriggIO TriggJ TriggL UnLoad VelSet vmax \
    WaitDI WaitDO WaitTime WaitUntil wobj0 wobjdata WorldAccLim zonedata";

/// Words of URScript (*The URScript Programming Language*), and functions and variables that a program of ours uses.
/// Case counts.
const URSCRIPT_RESERVED: &str = "\
    and break case continue def default elif else end enter_critical exit_critical False for global halt if in join \
    kill local loop mod not or pause pass return run sec struct switch sync thread True until while xor movej movel \
    roller conductor tape_heat tape_feed tape_press tape_cut tool_ready tape_hot tape_fed get_standard_digital_in \
    movep movec servoj stopj stopl pose_trans filament_full_scale nozzle pose_inv set_tcp set_payload \
    set_standard_digital_out set_standard_analog_out p sleep work filament_step rpm_per_mm_s modbus_add_signal \
    modbus_set_output_signal modbus_set_output_register modbus_set_signal_update_frequency socket_open socket_close \
    socket_send_line";

/// Words of KRL that a short name could be (*KSS 8.3 SI*, keywords). Case does not count.
const KRL_RESERVED: &str = "\
    AND ANIN ANOUT B_AND BOOL BRAKE CASE CAST_FROM CAST_TO CCLOSE CHAN_INFO CHAR CIRC CIRC_REL CONFIRM CONST CONTINUE \
    COPEN CREAD CWRITE DECL DEF DEFAULT DEFDAT DEFFCT DELAY DIGIN DISTANCE DO ELSE END ENDDAT ENDFCT ENDFOR ENDIF \
    ENDLOOP ENDSPLINE ENDSWITCH ENDWHILE ENUM EXIT EXT EXTFCT FALSE FOR FRAME GLOBAL GOTO HALT IF IMPORT INT INTERRUPT IS \
    LIN LIN_REL LOOP MINIMUM MAXIMUM NOT OFF ON OR POS AXIS E6POS E6AXIS PRIO PTP PTP_REL PUBLIC PULSE REAL REPEAT RESUME \
    RETURN SCIRC SIGNAL SLIN SPL SPLINE SPTP STRUC SWITCH SYNC THEN TO TRIGGER TRUE UNTIL WAIT WHEN WHILE WITH BAS IR_STOPM";

/// Programs that a Fanuc controller has by itself, and words of its instructions (*B-83284EN*). Case does not count.
const TP_RESERVED: &str = "\
    ABORT ALL AR BGLOGIC CALL COL CON DO DI ENDFOR END FOR IF JMP LBL LOCK MAIN MONITOR OFF ON OVERRIDE PAUSE PR PRN RI RO \
    RESUME_PROG RUN SELECT SKIP SR STOP TIMER TO UALM UNLOCK WAIT";

/// Letters that begin a name of RAPID's speeds and zones, before digits only.
const RAPID_NUMBERED: [&str; 4] = ["v", "z", "vrot", "vlin"];

/// Which language a name is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Rapid,
    UrScript,
    Krl,
    Tp,
}

/// Whether the language keeps a name for itself, and why.
fn kept(language: Language, name: &str) -> Option<&'static str> {
    let has = |words: &str| words.split_ascii_whitespace().any(|word| word.eq_ignore_ascii_case(name));
    match language {
        Language::Rapid if has(RAPID_RESERVED) => Some("it is a reserved word of RAPID"),
        Language::Rapid if has(RAPID_INSTALLED) || name.eq_ignore_ascii_case("main") || is_numbered(name) => {
            Some("RAPID has something else of that name")
        }
        Language::Krl if has(KRL_RESERVED) => Some("it is a word of KRL"),
        Language::Tp if has(TP_RESERVED) => Some("the controller has a program or an instruction of that name"),
        Language::UrScript if URSCRIPT_RESERVED.split_ascii_whitespace().any(|word| word == name) => {
            Some("it is a word of URScript")
        }
        _ => None,
    }
}

/// `v100`, `z10` and their like.
fn is_numbered(name: &str) -> bool {
    let digits = name.find(|c: char| c.is_ascii_digit()).filter(|at| name[*at..].bytes().all(|b| b.is_ascii_digit()));
    digits.is_some_and(|at| RAPID_NUMBERED.iter().any(|word| word.eq_ignore_ascii_case(&name[..at])))
}

/// Letters, digits and `_`, a letter first, not too long.
pub(crate) fn check_form(what: &'static str, name: &str, most: usize) -> Result<(), WriteError> {
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if plain && name.len() <= most && name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return Ok(());
    }
    let need = format!("letters, digits and _ only, a letter first, at most {most} of them");
    Err(WriteError::Name { what, name: name.to_owned(), need })
}

/// Whether a controller takes a name of ours.
pub(crate) fn check_name(language: Language, what: &'static str, name: &str, most: usize) -> Result<(), WriteError> {
    check_form(what, name, most)?;
    match kept(language, name) {
        None => Ok(()),
        Some(why) => Err(WriteError::Name { what, name: name.to_owned(), need: format!("{why}; take another") }),
    }
}

/// Most characters of a remark.
const MAX_REMARK: usize = 400;

/// Whether a remark is one line that every controller shows.
pub(crate) fn check_remark(what: &'static str, remark: Option<&str>) -> Result<(), WriteError> {
    let Some(remark) = remark else { return Ok(()) };
    if remark.len() <= MAX_REMARK && remark.chars().all(|c| c == ' ' || c.is_ascii_graphic()) {
        return Ok(());
    }
    let need = format!("one line of at most {MAX_REMARK} printable ASCII characters");
    Err(WriteError::Name { what, name: remark.chars().take(40).collect(), need })
}

/// Names that must all differ, whatever their case: RAPID has one table for modules, routines, data and signals.
pub(crate) fn check_distinct(names: &[(&'static str, &str)]) -> Result<(), WriteError> {
    for (k, &(what, name)) in names.iter().enumerate() {
        if let Some((other, _)) = names[..k].iter().find(|(_, before)| before.eq_ignore_ascii_case(name)) {
            let need = format!("`{other}` has the same name; RAPID wants two");
            return Err(WriteError::Name { what, name: name.to_owned(), need });
        }
    }
    Ok(())
}

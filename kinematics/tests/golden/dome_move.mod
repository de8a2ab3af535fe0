MODULE dome_move
  ! The link's task of the motion: it does the messages of the queue one after the other.
  PERS num dome_job:=0;
  PERS num dome_taken:=0;
  PERS num dome_done:=0;
  PERS num dome_fault:=0;
  PERS bool dome_hold:=FALSE;
  PERS string dome_kind{3}:=["","",""];
  PERS num dome_value{3,12}:=[[0,0,0,0,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0,0,0,0]];
  PERS string dome_word{3}:=["","",""];
  CONST jointtarget dome_home:=[[0,28.64789,-14.323945,0,57.29578,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR intnum dome_pause;
  VAR speeddata dome_speed:=[10,10,5000,1000];
  VAR bool dome_turns:=FALSE;
  VAR num dome_reversed:=0;
  VAR num dome_rpm:=0;
  PROC main()
    dome_off;
    ConfJ\Off;
    ConfL\Off;
    IDelete dome_pause;
    CONNECT dome_pause WITH dome_paused;
    IPers dome_hold,dome_pause;
    WHILE TRUE DO
      WaitUntil dome_fault=0 AND dome_done<dome_taken AND NOT dome_hold\PollRate:=0.01;
      dome_next;
    ENDWHILE
  ERROR
    dome_off;
    RAISE;
  ENDPROC
  ! Does the oldest message. It counts as done when the controller has it: at a rounded corner, a little before the robot is there.
  PROC dome_next()
    VAR num place;
    place:=dome_done MOD 3+1;
    TEST dome_kind{place}
    CASE "V":
      dome_speed:=[dome_value{place,1},dome_value{place,2},5000,1000];
    CASE "L","W":
      dome_pose place;
    CASE "A":
      dome_joints place;
    CASE "E":
      dome_extruder dome_word{place};
    DEFAULT:
      dome_fault:=dome_done+1;
    ENDTEST
    IF dome_fault=0 THEN
      dome_done:=dome_done+1;
    ELSE
      dome_off;
    ENDIF
  ERROR
    dome_fault:=dome_done+1;
    dome_off;
    RETURN;
  ENDPROC
  PROC dome_pose(num place)
    VAR robtarget goal:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR orient turned;
    VAR zonedata zone;
    zone:=dome_zone(dome_value{place,12});
    turned:=[dome_value{place,4},dome_value{place,5},dome_value{place,6},dome_value{place,7}];
    IF turned.q1=0 AND turned.q2=0 AND turned.q3=0 AND turned.q4=0 THEN
      ! No rotation has such a quaternion: it means home.
      MoveAbsJ dome_home,dome_speed,fine,tool0\WObj:=wobj0;
      RETURN;
    ENDIF
    goal.trans:=[dome_value{place,1},dome_value{place,2},dome_value{place,3}];
    goal.rot:=NOrient(turned);
    goal.robconf:=[dome_value{place,8},dome_value{place,9},dome_value{place,10},dome_value{place,11}];
    IF dome_kind{place}="L" THEN
      MoveL goal,dome_speed,zone,tool0\WObj:=wobj0;
    ELSE
      MoveJ goal,dome_speed,zone,tool0\WObj:=wobj0;
    ENDIF
  ENDPROC
  PROC dome_joints(num place)
    VAR jointtarget goal;
    VAR zonedata zone;
    zone:=dome_zone(dome_value{place,7});
    goal:=dome_home;
    goal.robax.rax_1:=dome_value{place,1};
    goal.robax.rax_2:=dome_value{place,2};
    goal.robax.rax_3:=dome_value{place,3};
    goal.robax.rax_4:=dome_value{place,4};
    goal.robax.rax_5:=dome_value{place,5};
    goal.robax.rax_6:=dome_value{place,6};
    MoveAbsJ goal,dome_speed,zone,tool0\WObj:=wobj0;
  ENDPROC
  FUNC zonedata dome_zone(num radius)
    VAR zonedata zone;
    zone:=fine;
    IF radius>=0 THEN
      zone:=[FALSE,radius,1.5*radius,1.5*radius,0.15*radius,1.5*radius,0.15*radius];
    ENDIF
    RETURN zone;
  ENDFUNC
  ! A command of the extruder: a word, and a number behind a comma.
  PROC dome_extruder(string command)
    VAR string word;
    VAR num comma;
    VAR num value:=0;
    comma:=StrFind(command,1,",");
    word:=StrPart(command,1,comma-1);
    IF comma<StrLen(command) THEN
      IF NOT StrToVal(StrPart(command,comma+1,StrLen(command)-comma),value) THEN
        dome_fault:=dome_done+1;
        RETURN;
      ENDIF
    ENDIF
    TEST word
    CASE "FORWARDS":
      dome_reversed:=0;
      SetDO doExtruderReverse,0;
    CASE "REVERSE":
      dome_reversed:=1;
      SetDO doExtruderReverse,1;
    CASE "START":
      dome_turns:=TRUE;
      SetDO doExtruder,1;
    CASE "STOP":
      dome_turns:=FALSE;
      SetDO doExtruder,0;
    CASE "RPM":
      dome_rpm:=value;
      SetAO aoExtruderRpm,value;
    CASE "PULSEREV":
      SetAO aoExtruderRpm,11;
      SetDO doExtruderReverse,1;
      SetDO doExtruder,1;
      WaitTime value/1000;
      IF NOT dome_turns THEN
        SetDO doExtruder,0;
      ENDIF
      SetDO doExtruderReverse,dome_reversed;
      SetAO aoExtruderRpm,dome_rpm;
    DEFAULT:
      dome_fault:=dome_done+1;
    ENDTEST
  ENDPROC
  PROC dome_off()
    dome_turns:=FALSE;
    SetDO doExtruder,0;
  ENDPROC
  ! Runs as soon as the other task changes the state, also in the middle of a move.
  TRAP dome_paused
    IF dome_hold THEN
      StopMove;
      SetDO doExtruder,0;
    ELSE
      StartMove;
      IF dome_turns THEN
        SetDO doExtruder,1;
      ENDIF
    ENDIF
  ENDTRAP
ENDMODULE

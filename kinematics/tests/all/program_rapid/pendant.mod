%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE Module1 (NOSTEPIN)
  ! made by hand at the pendant
  TASK PERS tooldata Extruder:=[TRUE,[[0,0,+148.5],[1,0,0,0]],[3.2,[0,-10,60],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata Bed:=[FALSE,TRUE,"",[[400,-20,5],[1,0,0,0]],[[10,0,0],[1,0,0,0]]];
  CONST jointtarget home:=[[0,-10,20,0,+30,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget above:=[[0,0,50],[0,0,1,0],[0,-1,0,0],[90,9E+09,9E+09,9E+09,9E+09,9E+09]];
  CONST robtarget p10:=[[+100,0,.5],[0,0,1,0],[0,-1,0,1],[1,-2,3,4,5,6]];
  LOCAL CONST robtarget p20:=[[100,50,0.5],[0.707,0.708,0,0],[0,-1,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata slow:=[20,45,5000,1000];
  PERS zonedata corner:=[FALSE,2.5,4,4,0.4,4,0.4];
  VAR num count:=0;
  VAR robtarget last;

  PROC main()
    ConfL\Off;
    SingArea\Wrist;
    AccSet 50,100;
    ActUnit STN_1;
    TPWrite "off it goes; and back";
    Reset doMelt;
    MOVEABSJ home\NoEOffs,V1000,Z50,tool0;
    Print;
    MoveAbsJ home,v150,fine,Extruder\WObj:=Bed;
  ERROR
    IF ERRNO=ERR_LOADED TRYNEXT;
    Reset doMelt;
    RAISE;
  ENDPROC

  LOCAL PROC Print()
    MoveJ above\ID:=10,v100,fine\Inpos:=inpos50,Extruder\WObj:=Bed;
    SetAO aoFeed,+2.5;
    Set doMelt;
    MoveL P10,v100\V:=12.5,z10,extruder\WObj:=bed;
    MoveL Offs(p10,0,50,0),slow,corner,Extruder\WObj:=Bed;
    MoveL RelTool(p10,0,0,-20),slow\V:=15,fine,Extruder\TLoad:=load0\WObj:=Bed;
    WaitTime\InPos,0.5;
    SetDO\Sync,doMelt,low;
    Set doMelt;
    MoveL\Conc,p20,vmax,fine,Extruder\WObj:=Bed;
    SetDO doMelt,0;
  ENDPROC
ENDMODULE

MODULE dome_001
  PROC dome_001_run()
    AccSet 50,50;
    PathAccLim TRUE\AccMax:=2,TRUE\DecelMax:=2;
    MoveAbsJ [[0,-28.64789,57.29578,14.323945,90,-180],[28.64789,-180,9E9,9E9,9E9,9E9]],[150,42.971835,5000,1000],[FALSE,2.5,3.75,3.75,0.375,3.75,0.375],nozzle\WObj:=part;
    MoveJ [[0,-12.25,25],[0,0.6,0.8,0],[0,-1,1,2],[9E9,9E9,9E9,9E9,9E9,9E9]],[100,57.29578,5000,1000],fine,nozzle\WObj:=part;
    MoveL [[0,-12.25,5],[0,0.6,0.8,0],[0,-1,1,2],[9E9,9E9,9E9,9E9,9E9,9E9]],[10,57.29578,5000,1000],fine,nozzle\WObj:=part;
    SetDO doExtruder,1;
    MoveL [[10.5,-12.25,5.0625],[0,0.6,0.8,0],[0,-1,1,2],[9E9,9E9,9E9,9E9,9E9,9E9]],[20,57.29578,5000,1000],z0,nozzle\WObj:=part;
    MoveL [[20,-12.25,5.5],[0,0.6,0.8,0],[0,-1,1,2],[9E9,9E9,9E9,9E9,9E9,9E9]],[20,57.29578,5000,1000],fine,nozzle\WObj:=part;
    SetDO doExtruder,0;
    MoveL [[20,-12.25,25.5],[0,0.6,0.8,0],[0,-1,1,2],[9E9,9E9,9E9,9E9,9E9,9E9]],[10,57.29578,5000,1000],fine,nozzle\WObj:=part;
  ENDPROC
ENDMODULE
